//! The edge profile: pixels sorted by their distance from the edge into bins a quarter of a pixel
//! wide (ISO 12233).
//!
//! A bin knows where its pixels really are: a model is averaged over those positions, not over the
//! bin, so that the phases of the pixel grid bias neither the measured curve nor the comparison.

use crate::photographs::edge::line::EdgeLine;
use crate::photographs::window::Window;

/// Width of a bin, pixels along the edge normal (fourfold oversampling, as ISO 12233).
pub(crate) const BIN_PX: f64 = 0.25;

/// Least share of the fullest pixel's worth of bins that a bin at the end of the profile must hold.
const COVERAGE: f64 = 0.3;

/// Bins -reach..=reach, centred on the edge; bin j is centred at j x [`BIN_PX`] on the bright side
/// for j > 0.
#[derive(Debug, Clone)]
pub struct Profile {
    /// Bins on either side of the central one.
    pub reach: usize,
    /// Pixels in each bin.
    pub count: Vec<f64>,
    /// Mean value of each bin; an empty bin holds the straight line between its neighbours.
    pub mean: Vec<f64>,
    /// Moments of the pixels' positions about the bin's centre, in excess of those of a uniformly
    /// filled bin: first (px), second (px^2), third (px^3).
    pub excess: Vec<[f64; 3]>,
    /// Variance of `mean` by pixel noise.
    pub variance: Vec<f64>,
    /// Standard deviation of one pixel at the dark and at the bright end.
    pub noise: [f64; 2],
}

/// Rise of an end, as a part of the step, from which on the blur counts as cut off by the window.
/// The 1/x tails of a separable lobe that the estimate allows for stay below 1 %.
const ENDS_RISE: f64 = 0.02;

#[derive(Clone, Copy, Default)]
struct Sums {
    n: f64,
    value: f64,
    value2: f64,
    s: [f64; 3],
    value_s: f64,
}

impl Profile {
    /// Sorts the window's pixels by their distance from `line`. `None` where fewer than 8 pixels on
    /// either side of the edge are covered.
    pub fn new(window: &Window, line: &EdgeLine) -> Option<Profile> {
        let limit = ((window.width() + window.height()) as f64 / BIN_PX) as usize;
        let mut sums = vec![Sums::default(); 2 * limit + 1];
        let (sin, cos) = line.normal_rad.sin_cos();
        for p in window.pixels() {
            let s = p.x * cos + p.y * sin - line.offset_px;
            let j = (s / BIN_PX).round();
            let d = s - j * BIN_PX;
            let bin = &mut sums[(j + limit as f64) as usize];
            bin.n += 1.0;
            bin.value += p.value;
            bin.value2 += p.value * p.value;
            bin.s[0] += d;
            bin.s[1] += d * d;
            bin.s[2] += d * d * d;
            bin.value_s += p.value * d;
        }
        let reach = covered(&sums, limit)?;
        let sums = &sums[limit - reach..=limit + reach];
        let mut profile = Profile {
            reach,
            count: sums.iter().map(|b| b.n).collect(),
            mean: sums.iter().map(|b| b.value / b.n).collect(),
            excess: sums
                .iter()
                .map(|b| {
                    if b.n > 0.0 {
                        [
                            b.s[0] / b.n,
                            b.s[1] / b.n - BIN_PX * BIN_PX / 12.0,
                            b.s[2] / b.n,
                        ]
                    } else {
                        [0.0; 3]
                    }
                })
                .collect(),
            variance: Vec::new(),
            noise: [0.0; 2],
        };
        profile.bridge_means();
        profile.estimate_noise(sums);
        Some(profile)
    }

    /// Number of bins.
    pub fn len(&self) -> usize {
        self.count.len()
    }

    /// Never true: a profile spans at least 8 pixels on either side.
    pub fn is_empty(&self) -> bool {
        self.count.is_empty()
    }

    /// Number of bins without a pixel.
    pub fn empty_bins(&self) -> usize {
        self.count.iter().filter(|&&n| n == 0.0).count()
    }

    /// What the user should know about the bins.
    pub fn warnings(&self, line: &EdgeLine) -> Vec<String> {
        let empty = self.empty_bins();
        let bridged = (empty > 0).then(|| {
            let angle = line.normal_rad.to_degrees();
            format!(
                "{empty} of {} bins hold no pixel at this edge angle ({angle:.2} deg): they are \
                bridged; \
                 avoid angles whose tangent is a simple fraction",
                self.len()
            )
        });
        let rise = self.rise_at_the_ends();
        let cut = (rise > ENDS_RISE).then(|| {
            format!(
                "the edge does not fade out within the window (it still rises by {:.0} % of its \
                step in the outer eighth): \
                 the numbers rest on what the window cuts off; give the edge more room, or even \
                 out the light",
                100.0 * rise
            )
        });
        bridged.into_iter().chain(cut).collect()
    }

    /// By how much of the whole step the profile changes over the outer eighth of its length, the
    /// larger of both ends, less what pixel noise explains (4.5 standard deviations).
    pub fn rise_at_the_ends(&self) -> f64 {
        let n = self.len();
        let end = (n / 8).max(4);
        let level = |bins: std::ops::Range<usize>| {
            let count = bins.len() as f64;
            let mean = bins.clone().map(|j| self.mean[j]).sum::<f64>() / count;
            let variance = bins.map(|j| self.variance[j]).sum::<f64>() / (count * count);
            (mean, variance)
        };
        // Means over the two halves of an end lie half an end apart: twice their difference is the
        // rise.
        let rise = |first: usize| {
            let (low, high) = (
                level(first..first + end / 2),
                level(first + end / 2..first + 2 * (end / 2)),
            );
            2.0 * ((high.0 - low.0).abs() - 4.5 * (low.1 + high.1).sqrt()).max(0.0)
        };
        let step = level(n - end..n).0 - level(0..end).0;
        rise(0).max(rise(n - end)) / step.abs()
    }

    /// Puts a straight line through empty bins of a curve over the bins: for the model the same as
    /// for the photograph.
    pub fn bridge(&self, curve: &mut [f64]) {
        let mut last = None;
        for j in 0..curve.len() {
            if self.count[j] == 0.0 {
                continue;
            }
            if let Some(from) = last.filter(|&from| from + 1 < j) {
                let step: f64 = (curve[j] - curve[from]) / (j - from) as f64;
                for k in from + 1..j {
                    curve[k] = curve[from] + step * (k - from) as f64;
                }
            }
            if last.is_none() {
                let first = curve[j];
                curve[..j].fill(first);
            }
            last = Some(j);
        }
        if let Some(from) = last {
            let end = curve[from];
            curve[from + 1..].fill(end);
        }
    }

    /// Puts straight lines through the empty bins of `mean`.
    pub fn bridge_means(&mut self) {
        let mut curve = std::mem::take(&mut self.mean);
        self.bridge(&mut curve);
        self.mean = curve;
    }

    /// Distance of a bin's centre from the edge, pixels, negative on the dark side.
    pub fn distance_px(&self, bin: usize) -> f64 {
        (bin as f64 - self.reach as f64) * BIN_PX
    }

    /// The profile at a distance from the edge (pixels), on straight lines between the bins; `None`
    /// beyond them.
    pub fn at(&self, distance_px: f64) -> Option<f64> {
        let at = distance_px / BIN_PX + self.reach as f64;
        let last = (self.len() - 1) as f64;
        (0.0..last).contains(&at).then(|| {
            let j = at as usize;
            self.mean[j] + (self.mean[j + 1] - self.mean[j]) * at.fract()
        })
    }

    /// Mean level of the outer twelfth of the bins on the dark and on the bright side.
    pub fn plateaus(&self) -> (f64, f64) {
        let ends = (self.len() / 12).max(4);
        let level = |bins: &[f64]| bins.iter().sum::<f64>() / bins.len() as f64;
        (
            level(&self.mean[..ends]),
            level(&self.mean[self.len() - ends..]),
        )
    }

    /// Slope of the profile at bin j, per pixel, over +-`half` bins.
    pub fn slope(&self, j: usize, half: usize) -> f64 {
        let (low, high) = (j.saturating_sub(half), (j + half).min(self.len() - 1));
        (self.mean[high] - self.mean[low]) / ((high - low) as f64 * BIN_PX)
    }

    /// Pixel noise from the scatter within bins, as a straight line in the level (shot and read
    /// noise); the variance of a bin's mean is that over its count.
    fn estimate_noise(&mut self, sums: &[Sums]) {
        let (mut w, mut wx, mut wy, mut wxx, mut wxy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (j, b) in sums.iter().enumerate().filter(|(_, b)| b.n >= 6.0) {
            // Scatter about the local slope, whose share of the variance is known.
            let (m, slope) = (b.value / b.n, self.slope(j, 2));
            let (ds, dv) = (
                b.s[1] - b.s[0] * b.s[0] / b.n,
                b.value_s - b.value * b.s[0] / b.n,
            );
            let scatter = (b.value2 - b.value * m - 2.0 * slope * dv + slope * slope * ds).max(0.0);
            let variance = scatter / (b.n - 1.0);
            w += b.n;
            wx += b.n * m;
            wy += b.n * variance;
            wxx += b.n * m * m;
            wxy += b.n * m * variance;
        }
        let (low, high) = self
            .mean
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &m| {
                (l.min(m), h.max(m))
            });
        // A floor far below any sensor's noise keeps noise-free pictures from dividing by zero.
        let floor = 1e-12 * (high - low).powi(2) + f64::MIN_POSITIVE;
        let spread = w * wxx - wx * wx;
        let average = if w > 0.0 { (wy / w).max(floor) } else { floor };
        let gain = if spread > 1e-9 * w * wxx {
            ((w * wxy - wx * wy) / spread).max(0.0)
        } else {
            0.0
        };
        let centre = if w > 0.0 { wx / w } else { 0.0 };
        let pixel = |level: f64| {
            (average + gain * (level - centre))
                .max(0.05 * average)
                .max(floor)
        };
        self.variance = self
            .mean
            .iter()
            .zip(&self.count)
            .map(|(&m, &n)| pixel(m) / if n > 0.0 { n } else { 1.0 })
            .collect();
        self.noise = [pixel(low).sqrt(), pixel(high).sqrt()];
    }
}

/// The greatest reach with bins well filled on both sides, judged over one pixel (an angle whose
/// tangent is a simple fraction leaves single bins empty).
fn covered(sums: &[Sums], limit: usize) -> Option<usize> {
    let per_px = (1.0 / BIN_PX) as usize;
    let filled = |from: usize| -> f64 { sums[from..from + per_px].iter().map(|b| b.n).sum() };
    let most = (0..sums.len() - per_px).map(filled).fold(0.0, f64::max);
    let enough = |n: f64| n >= COVERAGE * most;
    let right = (limit..sums.len() - per_px)
        .take_while(|&j| enough(filled(j)))
        .count();
    let left = (1..=limit)
        .take_while(|&k| enough(filled(limit + 1 - k.min(limit)).min(filled(limit - k))))
        .count();
    let reach = right.min(left);
    (reach >= 8 * per_px).then_some(reach)
}

/// Running mean over +-`half` bins (shorter, but symmetric, towards the ends).
pub(crate) fn smoothed(curve: &[f64], half: usize) -> Vec<f64> {
    (0..curve.len())
        .map(|j| {
            let h = half.min(j).min(curve.len() - 1 - j);
            curve[j - h..=j + h].iter().sum::<f64>() / (2 * h + 1) as f64
        })
        .collect()
}
