//! Noise that neighbouring pixels share, as demosaicing, smoothing and JPEG leave it.
//!
//! Means over many pixels then scatter more than the scatter of single pixels tells. The factor is
//! the sum of the autocorrelation of the noise: its power at low spatial frequencies over the
//! variance of a pixel. A mid-air edge is blurred over many pixels, so low frequencies decide.
//!
//! Light that the profile does not describe is correlated too, but over longer distances. So a
//! polynomial of each side of the edge is taken out, and so is what remains at lags beyond those of
//! the noise.

use crate::numerics::factor;
use crate::numerics::factor::Products;
use crate::photographs::edge::line::EdgeLine;
use crate::photographs::edge::line::legendre;
use crate::photographs::profile::{BIN_PX, Profile, bin_at};
use crate::photographs::window::Window;

/// Number of standard deviations from which a correlation of direct neighbours is believed. White
/// noise reaches it in one photograph of 10^8.
const BELIEVED: f64 = 6.0;

/// Farthest lag that counts, pixels: two blocks of JPEG share no rounding, and demosaicing reaches
/// less far.
const FARTHEST: isize = 8;

/// Nearest and farthest lag at which nothing but light is shared.
const LIGHT: [isize; 2] = [12, 16];

/// Lags of direct neighbours.
const NEXT: [[isize; 2]; 4] = [[1, 0], [0, 1], [1, 1], [-1, 1]];

/// Some of the lags at which nothing but light is shared.
const FAR: [[isize; 2]; 8] = [
    [12, 0],
    [16, 0],
    [0, 12],
    [0, 16],
    [12, 12],
    [-12, 12],
    [16, 16],
    [-16, 16],
];

/// Correlation at far lags above which light is taken out. Below it light adds at most 0.01 at each
/// of the lags that count, less what is subtracted.
const SHARED_LIGHT: f64 = 0.01;

/// Degree of the polynomial that is taken out, and the number of its terms.
const DEGREE: usize = 4;
const TERMS: usize = (DEGREE + 1) * (DEGREE + 2) / 2;

/// Largest side of the part of a window that is looked at.
const LARGEST: usize = 1024;

/// Standard deviation of a pixel, as a share of the step, below which a picture has no noise. What
/// is left of the profile is then interpolation.
const NO_NOISE: f64 = 1e-4;

/// Rise of the profile over a bin, in standard deviations of a pixel, up to which a pixel counts.
/// Where the edge is steeper, an edge that is slightly wavy looks like correlated noise.
const FLAT: f64 = 0.3;

/// Returns the factor by which the variance of means over many pixels exceeds that of independent
/// pixels, at least 1. It is exactly 1 unless neighbouring pixels are clearly correlated.
///
/// Sharpening makes it smaller than 1, which is not used: the standard errors are then too large.
pub(crate) fn excess(window: &Window, line: &EdgeLine, profile: &Profile) -> f64 {
    let (dark, bright) = profile.plateaus();
    let average = 0.5 * (profile.noise[0] + profile.noise[1]);
    if average.is_nan() || average <= NO_NOISE * (bright - dark) {
        return 1.0;
    }
    let mut residuals = Residuals::new(window, line, profile);
    if !residuals.are_correlated() {
        return 1.0;
    }
    let mut far = residuals.mean(farther());
    if far.abs() > SHARED_LIGHT * residuals.product([0, 0])[0] {
        residuals.take_light_out();
        if !residuals.are_correlated() {
            return 1.0;
        }
        far = residuals.mean(farther());
    }
    let near = residuals.mean(half_of(FARTHEST));
    let variance = residuals.product([0, 0])[0] - far;
    // Each lag stands for itself and for its opposite.
    let lags = 2.0 * half_of(FARTHEST).count() as f64;
    (1.0 + lags * (near - far) / variance).max(1.0)
}

/// Returns one lag of each pair of opposite ones, up to `most` pixels along either axis.
fn half_of(most: isize) -> impl Iterator<Item = [isize; 2]> {
    let all = (0..=most).flat_map(move |dy| (-most..=most).map(move |dx| [dx, dy]));
    all.filter(|&[dx, dy]| dy > 0 || dx > 0)
}

/// Returns the lags at which nothing but light is shared.
fn farther() -> impl Iterator<Item = [isize; 2]> {
    half_of(LIGHT[1]).filter(|lag| longest(lag) >= LIGHT[0])
}

fn longest(&[dx, dy]: &[isize; 2]) -> isize {
    dx.abs().max(dy.abs())
}

/// Distances of the pixels from the profile, in standard deviations of a pixel. They are 0 for
/// pixels that are left out, beyond the profile, or on the steep part of the edge.
struct Residuals {
    width: usize,
    height: usize,
    values: Vec<f32>,
    /// 1 for the pixels that count, else 0.
    held: Vec<f32>,
    /// True for pixels on the bright side.
    bright: Vec<bool>,
}

impl Residuals {
    fn new(window: &Window, line: &EdgeLine, profile: &Profile) -> Residuals {
        let ruler = line.ruler();
        let [width, height] = [window.width(), window.height()].map(|side| side.min(LARGEST));
        let deviation = |bin: usize| {
            let deviation = profile.deviation(bin, window.excess());
            let is_flat = profile.slope(bin, 4).abs() * BIN_PX < FLAT * deviation;
            is_flat.then_some(deviation)
        };
        let deviations: Vec<Option<f64>> = (0..profile.len()).map(deviation).collect();
        let mut residuals = Residuals {
            width,
            height,
            values: vec![0.0; width * height],
            held: vec![0.0; width * height],
            bright: vec![false; width * height],
        };
        let [left, top] = [window.width() - width, window.height() - height].map(|side| side / 2);
        let centre = [window.width(), window.height()].map(|side| 0.5 * (side as f64 - 1.0));
        for at in 0..width * height {
            let (column, row) = (left + at % width, top + at / width);
            let value = f64::from(window.at(column, row));
            let (x, y) = (column as f64 - centre[0], row as f64 - centre[1]);
            let (across_px, _) = ruler.place(x, y);
            let Some(level) = profile.at(across_px).filter(|_| !value.is_nan()) else {
                continue;
            };
            let bin = bin_at(across_px) + profile.reach as f64;
            if let Some(deviation) = deviations[bin as usize] {
                residuals.values[at] = ((value - level) / deviation) as f32;
                residuals.held[at] = 1.0;
                residuals.bright[at] = across_px > 0.0;
            }
        }
        residuals
    }

    /// Returns whether direct neighbours are clearly correlated.
    fn are_correlated(&self) -> bool {
        let far = self.mean(FAR.into_iter());
        let variance = self.product([0, 0])[0] - far;
        let is_clear = |&lag: &[isize; 2]| {
            let [mean, pairs] = self.product(lag);
            // `far` is a mean of eight such products.
            let error = variance * (1.125 / pairs.max(1.0)).sqrt();
            pairs > 0.0 && (mean - far).abs() > BELIEVED * error
        };
        variance > 0.0 && NEXT.iter().any(is_clear)
    }

    /// Takes a polynomial of each side out of the pixels.
    fn take_light_out(&mut self) {
        for side in [false, true] {
            let counts = |at: &usize| self.held[*at] > 0.0 && self.bright[*at] == side;
            let places: Vec<usize> = (0..self.values.len()).filter(counts).collect();
            let mut normal = Products::new(TERMS + 1);
            for &at in &places {
                let mut row = [0.0; TERMS + 1];
                row[..TERMS].copy_from_slice(&self.terms(at));
                row[TERMS] = f64::from(self.values[at]);
                normal.add(&row);
            }
            let found = factor::back_substituted(&factor::of(normal.sum()), TERMS, TERMS);
            for &at in &places {
                let terms = self.terms(at);
                let light: f64 = terms.iter().zip(found.iter()).map(|(t, c)| t * c).sum();
                self.values[at] -= light as f32;
            }
        }
    }

    /// Returns the terms of the polynomial at a pixel.
    fn terms(&self, at: usize) -> [f64; TERMS] {
        let place = |at: usize, side: usize| 2.0 * at as f64 / side as f64 - 1.0;
        let (x, _) = legendre(place(at % self.width, self.width));
        let (y, _) = legendre(place(at / self.width, self.height));
        let mut terms = [0.0; TERMS];
        let pairs = (0..=DEGREE).flat_map(|i| (0..=DEGREE - i).map(move |j| (i, j)));
        for (term, (i, j)) in terms.iter_mut().zip(pairs) {
            *term = x[i] * y[j];
        }
        terms
    }

    /// Returns the mean of the mean products at some lags.
    fn mean(&self, lags: impl Iterator<Item = [isize; 2]>) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for lag in lags {
            sum += self.product(lag)[0];
            count += 1.0;
        }
        sum / count
    }

    /// Returns the mean product of pixels that lie `dx` columns and `dy` >= 0 rows apart, and the
    /// number of pairs.
    fn product(&self, [dx, dy]: [isize; 2]) -> [f64; 2] {
        let columns = self.width.saturating_sub(dx.unsigned_abs());
        let rows = self.height.saturating_sub(dy.unsigned_abs());
        if columns == 0 {
            return [0.0; 2];
        }
        let (first, second) = ((-dx).max(0) as usize, dx.max(0) as usize);
        let (mut sum, mut pairs) = (0.0, 0.0);
        for y in 0..rows {
            let (row, below) = (y * self.width, (y + dy.unsigned_abs()) * self.width);
            let dot = |all: &[f32]| -> f32 {
                let (row, below) = (&all[row + first..], &all[below + second..]);
                let pairs = row.iter().zip(below).take(columns);
                pairs.map(|(a, b)| a * b).sum()
            };
            // The sum of one row in f32 is exact to 1e-5 of it.
            sum += f64::from(dot(&self.values));
            pairs += f64::from(dot(&self.held));
        }
        [sum / f64::max(pairs, 1.0), pairs]
    }
}
