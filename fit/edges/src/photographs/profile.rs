//! The edge profile: pixels sorted by their distance from the edge into bins a quarter of a pixel
//! wide (ISO 12233).
//!
//! A bin stores the moments of its pixels' positions. A model is averaged over these positions, not
//! over the bin. The phases of the pixel grid then bias neither the measured curve nor the
//! comparison.

use nalgebra::DMatrix;

use crate::photographs::edge::line::EdgeLine;
use crate::photographs::window::Window;

/// Width of a bin, pixels along the edge normal (fourfold oversampling, as in ISO 12233).
pub const BIN_PX: f64 = 0.25;

/// Returns the bin that holds a distance from the edge (pixels), counted from that on the edge. On
/// the border of two bins it is the even one.
///
/// The sum leaves no digits behind the point below 2^49 pixels. `f64::round` is a call of a function
/// where a program is compiled for every x86-64.
#[inline]
pub fn bin_at(distance_px: f64) -> f64 {
    const WHOLE: f64 = 1.5 * (1_u64 << 52) as f64;
    (distance_px / BIN_PX + WHOLE) - WHOLE
}

/// Least number of pixels per pixel of length at the ends of the profile, as a share of the
/// largest.
const COVERAGE: f64 = 0.3;

/// The edge profile on 2 `reach` + 1 bins, of which the central one lies on the edge. The bin j
/// places from it is centred at j x [`BIN_PX`] pixels from the edge; j > 0 is the bright side.
#[derive(Debug, Clone)]
pub struct Profile {
    /// Number of bins on either side of the central one.
    pub reach: usize,
    /// Number of pixels in each bin.
    pub count: Vec<f64>,
    /// Mean value of each bin, linear light. An empty bin lies on the straight line between its
    /// neighbours.
    pub mean: Vec<f64>,
    /// First (px), second (px^2) and third (px^3) moments of the pixels' positions about the bin's
    /// centre, less those of a uniformly filled bin. In an empty bin the first one lies on the
    /// straight line between its neighbours.
    pub excess: Vec<[f64; 3]>,
    /// Variance of `mean` by pixel noise.
    pub variance: Vec<f64>,
    /// Standard deviation of one pixel by noise at the dark and at the bright end.
    pub noise: [f64; 2],
    /// What the correction of uneven light adds to the noise; `None` in even light.
    pub light: Option<Noise>,
}

/// Noise of the estimate of the light in the means of the bins, which the light divides.
///
/// A mean that is evened out is its own noise, less `by_light` times the error of the light. The
/// error of the light is `by_bin` times the noise of the means, and `others` times independent
/// numbers of variance 1.
#[derive(Debug, Clone)]
pub struct Noise {
    /// Change of the means (rows) by each term of the light (columns).
    pub(crate) by_light: DMatrix<f64>,
    /// Change of each term (rows) by the mean of each bin (columns).
    pub(crate) by_bin: DMatrix<f64>,
    /// Change of each term (rows) by one standard deviation of what is independent of the means.
    pub(crate) others: DMatrix<f64>,
}

/// Least rise of an end, as a share of the step, for which the blur counts as cut off by the
/// window. The 1/x tails of a separable lobe that the estimate allows for stay below 1 %.
const ENDS_RISE: f64 = 0.02;

/// Number of pixels from which a bin tells the noise of a pixel well.
const MANY: f64 = 6.0;

#[derive(Clone, Copy, Default)]
struct Sums {
    n: f64,
    value: f64,
    value2: f64,
    s: [f64; 3],
    value_s: f64,
}

impl Profile {
    /// Sorts the window's pixels by their distance from `line`. Returns `None` if fewer than 8
    /// pixels on either side of the edge are covered.
    pub fn new(window: &Window, line: &EdgeLine) -> Option<Profile> {
        let limit = ((window.width() + window.height()) as f64 / BIN_PX) as usize;
        let mut sums = vec![Sums::default(); 2 * limit + 1];
        let ruler = line.ruler();
        window.pixels().for_each(|p| {
            let (s, _) = ruler.place(p.x, p.y);
            let j = bin_at(s);
            let d = s - j * BIN_PX;
            // A line that was sought in vain can lie outside of the window, and its curve far off.
            let place = j + limit as f64;
            if !(0.0..sums.len() as f64).contains(&place) {
                return;
            }
            let bin = &mut sums[place as usize];
            bin.n += 1.0;
            bin.value += p.value;
            bin.value2 += p.value * p.value;
            bin.s[0] += d;
            bin.s[1] += d * d;
            bin.s[2] += d * d * d;
            bin.value_s += p.value * d;
        });
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
            light: None,
        };
        profile.bridge_means();
        let mut first: Vec<f64> = profile.excess.iter().map(|moments| moments[0]).collect();
        profile.bridge(&mut first);
        for (moments, first) in profile.excess.iter_mut().zip(first) {
            moments[0] = first;
        }
        profile.estimate_noise(sums, window.excess());
        Some(profile)
    }

    /// Returns the number of bins.
    pub fn len(&self) -> usize {
        self.count.len()
    }

    /// Returns whether there are no bins. It is never true: a profile spans at least 8 pixels on
    /// either side.
    pub fn is_empty(&self) -> bool {
        self.count.is_empty()
    }

    /// Returns the number of bins without a pixel.
    pub fn empty_bins(&self) -> usize {
        self.count.iter().filter(|&&n| n == 0.0).count()
    }

    /// Returns the root mean square distance of the pixels from the mean place of their bin, in
    /// pixels.
    ///
    /// Bins that are filled evenly have [`BIN_PX`] / sqrt(12) = 0.072.
    pub(crate) fn spread_within_px(&self) -> f64 {
        let filled = self.count.iter().zip(&self.excess);
        let squares = filled.map(|(n, [first, second, _])| {
            n * (second + BIN_PX * BIN_PX / 12.0 - first * first).max(0.0)
        });
        (squares.sum::<f64>() / self.count.iter().sum::<f64>()).sqrt()
    }

    /// Returns warnings about empty bins and about an edge that does not fade out in the window.
    pub fn warnings(&self, line: &EdgeLine) -> Vec<String> {
        let empty = self.empty_bins();
        let bridged = (empty > 0).then(|| {
            let angle = line.normal_rad.to_degrees();
            format!(
                "{empty} of {} bins hold no pixel at this edge angle ({angle:.2} deg): straight \
                lines between their neighbours fill them; avoid angles whose tangent is a simple \
                fraction",
                self.len()
            )
        });
        let rise = self.rise_at_the_ends();
        let cut = (rise > ENDS_RISE).then(|| {
            format!(
                "the edge does not fade out within the window (in its outer eighth it still rises \
                by {:.0} % of its step): the result depends on what the window cuts off; give the \
                edge more room, or even out the light",
                100.0 * rise
            )
        });
        bridged.into_iter().chain(cut).collect()
    }

    /// Returns the change of the profile over the outer eighth of its length, as a share of the
    /// step. It is the larger value of both ends, less what pixel noise explains (4.5 standard
    /// deviations).
    pub fn rise_at_the_ends(&self) -> f64 {
        let n = self.len();
        let end = (n / 8).max(4);
        let level = |bins: std::ops::Range<usize>| {
            let count = bins.len() as f64;
            let mean = bins.clone().map(|j| self.mean[j]).sum::<f64>() / count;
            let variance = bins.map(|j| self.variance[j]).sum::<f64>() / (count * count);
            (mean, variance)
        };
        // The means of the two halves of an end lie half an end apart, so twice their difference is
        // the rise.
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

    /// Puts straight lines through the empty bins of a curve over the bins. The photograph's curve
    /// and the model's are treated alike.
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

    /// Returns the response of linear functions of the means to noise: their change by one standard
    /// deviation of each independent number.
    ///
    /// Rows are functions. The columns of `by_bin` are bins, those of the result independent
    /// numbers: the bins, and in uneven light some more.
    pub fn response(&self, mut by_bin: DMatrix<f64>) -> DMatrix<f64> {
        let by_light = self.light.as_ref().map(|light| &by_bin * &light.by_light);
        if let (Some(light), Some(by_light)) = (&self.light, &by_light) {
            by_bin -= by_light * &light.by_bin;
        }
        for (mut bin, variance) in by_bin.column_iter_mut().zip(&self.variance) {
            bin *= variance.sqrt();
        }
        if let (Some(light), Some(by_light)) = (&self.light, &by_light) {
            let (own, others) = (by_bin.ncols(), by_light * &light.others);
            by_bin = by_bin.resize_horizontally(own + others.ncols(), 0.0);
            by_bin.columns_mut(own, others.ncols()).copy_from(&others);
        }
        by_bin
    }

    /// Returns the variance that noise gives a linear function of the means.
    pub fn variance_of<'w>(&self, by_bin: impl Iterator<Item = &'w f64> + Clone) -> f64 {
        if self.light.is_some() {
            let row = DMatrix::from_iterator(1, self.len(), by_bin.copied());
            return self.response(row).norm_squared();
        }
        let bins = by_bin.zip(&self.variance);
        bins.map(|(w, v)| w * w * v).sum()
    }

    /// Returns the standard deviation of one pixel in a bin, of which means count `excess` times.
    pub(crate) fn deviation(&self, bin: usize, excess: f64) -> f64 {
        (self.variance[bin] * self.count[bin].max(1.0) / excess).sqrt()
    }

    /// Returns the distance of a bin's centre from the edge, pixels, negative on the dark side.
    pub fn distance_px(&self, bin: usize) -> f64 {
        (bin as f64 - self.reach as f64) * BIN_PX
    }

    /// Returns the mean distance of a bin's pixels from the edge (pixels). An empty bin lies on the
    /// straight line between its neighbours.
    fn place_px(&self, bin: usize) -> f64 {
        self.distance_px(bin) + self.excess[bin][0]
    }

    /// Returns the profile at a distance from the edge (pixels), on straight lines between the mean
    /// places of the bins. Returns `None` beyond the middles of the outermost bins.
    ///
    /// An edge that is inclined by a ratio of small numbers has few distances. From the middles of
    /// the bins the lines would miss its pixels by as much as their noise.
    pub fn at(&self, distance_px: f64) -> Option<f64> {
        let (from, last) = (self.distance_px(0), self.len() - 1);
        (from..-from).contains(&distance_px).then(|| {
            let bin = (bin_at(distance_px) + self.reach as f64) as usize;
            let next = bin + usize::from(distance_px >= self.place_px(bin));
            if next == 0 || next > last {
                return self.mean[bin];
            }
            let (x, y) = (self.place_px(next - 1), self.mean[next - 1]);
            let share = (distance_px - x) / (self.place_px(next) - x);
            // Pixels on the border of two bins may leave both at one place.
            y + (self.mean[next] - y) * share.min(1.0)
        })
    }

    /// Returns the mean levels of the outer twelfth of the bins, on the dark and on the bright
    /// side.
    pub fn plateaus(&self) -> (f64, f64) {
        let ends = (self.len() / 12).max(4);
        let level = |bins: &[f64]| bins.iter().sum::<f64>() / bins.len() as f64;
        (
            level(&self.mean[..ends]),
            level(&self.mean[self.len() - ends..]),
        )
    }

    /// Returns the slope of the profile at bin j, per pixel, over +-`half` bins (at least 2).
    pub fn slope(&self, j: usize, half: usize) -> f64 {
        let (low, high) = (j.saturating_sub(half), (j + half).min(self.len() - 1));
        (self.mean[high] - self.mean[low]) / (self.place_px(high) - self.place_px(low))
    }

    /// Estimates the pixel noise from the scatter within bins. The variance of a pixel is a
    /// straight line in the level (read and shot noise); the variance of a bin's mean is that
    /// divided by its count, times the `excess` of correlated pixels.
    fn estimate_noise(&mut self, sums: &[Sums], excess: f64) {
        let (mut w, mut wx, mut wy, mut wxx, mut wxy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let pixels = |least: f64| {
            let bins = sums.iter().filter(|b| b.n >= least);
            bins.map(|b| b.n).sum::<f64>()
        };
        // In a short window all bins have few pixels.
        let least = if pixels(MANY) < 0.5 * pixels(0.0) {
            2.0
        } else {
            MANY
        };
        for (j, b) in sums.iter().enumerate().filter(|(_, b)| b.n >= least) {
            // Scatter about the local slope: the part of the variance that the slope makes is
            // known.
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
        // This floor is far below the noise of any sensor. It avoids a division by zero for
        // pictures without noise.
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
            .map(|(&m, &n)| excess * pixel(m) / if n > 0.0 { n } else { 1.0 })
            .collect();
        self.noise = [pixel(low).sqrt(), pixel(high).sqrt()];
    }
}

/// Returns the greatest reach with bins that are well filled on both sides, or `None` if it is
/// below 8 pixels. Filling is judged over one pixel, because an angle whose tangent is a simple
/// fraction leaves single bins empty.
fn covered(sums: &[Sums], limit: usize) -> Option<usize> {
    let per_px = (1.0 / BIN_PX) as usize;
    let filled = |from: usize| -> f64 { sums[from..from + per_px].iter().map(|b| b.n).sum() };
    let most = (0..sums.len() - per_px).map(filled).fold(0.0, f64::max);
    let enough = |n: f64| n > 0.0 && n >= COVERAGE * most;
    let right = (limit..sums.len() - per_px)
        .take_while(|&j| enough(filled(j)))
        .count();
    let left = (1..=limit)
        .take_while(|&k| enough(filled(limit + 1 - k.min(limit)).min(filled(limit - k))))
        .count();
    let reach = right.min(left);
    (reach >= 8 * per_px).then_some(reach)
}

/// Returns the running mean over +-`half` bins. Towards the ends the range is shorter, but
/// symmetric.
pub(crate) fn smoothed(curve: &[f64], half: usize) -> Vec<f64> {
    (0..curve.len())
        .map(|j| {
            let h = half.min(j).min(curve.len() - 1 - j);
            curve[j - h..=j + h].iter().sum::<f64>() / (2 * h + 1) as f64
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::photographs::photo;

    /// Checks the rise of a ramp by hand. It has 201 bins, so an end has 25 and its halves have 12
    /// each. They lie 12 bins apart, twice of which is the rise; the ends lie 176 bins apart. Noise
    /// of the variance v takes 4.5 sqrt(2 v / 12) from the difference of the halves. The sums of 25
    /// numbers up to 200 round by less than 1e-12 of the result.
    #[test]
    fn the_rise_of_a_ramp_is_that_of_its_ends() {
        let ramp = |variance: f64| Profile {
            reach: 100,
            count: vec![20.0; 201],
            mean: (0..201).map(f64::from).collect(),
            excess: vec![[0.0; 3]; 201],
            variance: vec![variance; 201],
            noise: [1.0; 2],
            light: None,
        };
        let cases: [(f64, f64); 3] = [(0.0, 24.0), (0.24, 24.0 - 1.8), (400.0, 0.0)];
        for (variance, rise) in cases {
            let found = ramp(variance).rise_at_the_ends();
            assert!((found - rise / 176.0).abs() < 1e-12, "{variance}: {found}");
        }
        assert_eq!(cases.len(), 3);
    }

    /// Checks the profile of an edge inclined by 1 : 3. Its pixels have distances that are multiples
    /// of 1/sqrt(10) = 0.316 px and leave bins empty. Light that rises evenly is a straight line, so
    /// the profile holds at every distance between the outermost pixels. f32 rounds the light to
    /// 6e-8 of 1, and the bins are means of such numbers.
    #[test]
    fn the_profile_of_a_simple_slope_holds_between_its_pixels() {
        let normal_rad = (1.0_f64 / 3.0).atan();
        let (sin, cos) = normal_rad.sin_cos();
        let light = |s: f64| 0.5 + 0.01 * s;
        let picture = photo(60, 60, |x, y| light((x - 29.5) * cos + (y - 29.5) * sin));
        let window = Window::of(&picture, None).expect("is not empty");
        let edge = EdgeLine {
            normal_rad,
            offset_px: 0.0,
            normal_standard_error_rad: 0.0,
            bend: None,
        };
        let profile = Profile::new(&window, &edge).expect("covers the edge");
        assert!(profile.empty_bins() > 0);
        let mut cases = 0;
        for k in -600..=600 {
            let distance_px = 0.017 * f64::from(k);
            let Some(found) = profile.at(distance_px) else {
                continue;
            };
            assert!(
                (found - light(distance_px)).abs() < 1e-7,
                "{distance_px}: {found}"
            );
            cases += 1;
        }
        assert!(cases > 900, "{cases} distances");
    }

    /// Checks the noise of bins of few pixels by hand. Bins of 6 pixels at the level 1 scatter by
    /// 0.1 about their mean, and bins of 10 at the level 3 by 0.2: pixels have the variances
    /// 6/5 x 0.01 and 10/9 x 0.04. The line through both holds at the level 2 of the last bin,
    /// whose 5 pixels are too few to count. Sums of numbers up to 90 round by less than 1e-12 of
    /// the least scatter, 0.06.
    #[test]
    fn the_noise_of_few_pixels_is_over_their_degrees_of_freedom() {
        let kinds = [(6.0, 1.0, 0.1), (10.0, 3.0, 0.2), (5.0, 2.0, 9.0)];
        let bins: Vec<(f64, f64, f64)> = [0, 1, 0, 1, 1, 0, 0, 1, 2].map(|k| kinds[k]).to_vec();
        let sums: Vec<Sums> = bins
            .iter()
            .map(|&(n, level, off)| Sums {
                n,
                value: n * level,
                value2: n * (level * level + off * off),
                ..Sums::default()
            })
            .collect();
        let mut profile = Profile {
            reach: 4,
            count: bins.iter().map(|bin| bin.0).collect(),
            mean: bins.iter().map(|bin| bin.1).collect(),
            excess: vec![[0.0; 3]; 9],
            variance: Vec::new(),
            noise: [0.0; 2],
            light: None,
        };
        profile.estimate_noise(&sums, 2.5);
        let pixel = [1.2 * 0.01, 0.04 / 0.9];
        let expected = [
            pixel[0] / 6.0,
            pixel[1] / 10.0,
            0.5 * (pixel[0] + pixel[1]) / 5.0,
        ];
        let mut cases = 0;
        for (found, bin) in profile.variance.iter().zip(&bins) {
            let kind = kinds
                .iter()
                .position(|kind| kind == bin)
                .expect("one of them");
            let ratio = found / (2.5 * expected[kind]);
            assert!((ratio - 1.0).abs() < 1e-10, "{bin:?}: {ratio}");
            cases += 1;
        }
        assert_eq!(cases, 9);
        for (found, variance) in profile.noise.into_iter().zip(pixel) {
            assert!((found.powi(2) / variance - 1.0).abs() < 1e-10, "{found}");
        }
    }
}
