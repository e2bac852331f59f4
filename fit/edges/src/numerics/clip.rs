//! A normal variable cut off at 0 or at full scale, as a camera cuts off its noise.

use std::f64::consts::{PI, SQRT_2};

/// Limits at which a camera cuts its signal off. They lie so far apart that a pixel feels one at
/// most.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cut {
    /// True if values below 0 become 0.
    pub zero: bool,
    /// Value that larger ones become.
    pub full: Option<f64>,
}

impl Cut {
    /// Returns whether there is a limit.
    pub fn is_any(self) -> bool {
        self.zero || self.full.is_some()
    }

    /// Returns the mean of a normal variable after the cut, its derivative by `mean`, and its
    /// variance. `mean` and the standard deviation `sigma` > 0 are those before the cut.
    pub fn clipped(self, mean: f64, sigma: f64) -> (f64, f64, f64) {
        match self.above(mean) {
            Some(full) => {
                let (below, slope, variance) = clipped(full - mean, sigma);
                (full - below, slope, variance)
            }
            None if self.zero => clipped(mean, sigma),
            None => (mean, 1.0, sigma * sigma),
        }
    }

    /// Returns the Fisher information of one observation on the mean, in units of 1/sigma^2.
    pub fn information(self, mean: f64, sigma: f64) -> f64 {
        match self.above(mean) {
            Some(full) => information(full - mean, sigma),
            None if self.zero => information(mean, sigma),
            None => 1.0,
        }
    }

    /// Returns the upper limit if it is the nearer one.
    fn above(self, mean: f64) -> Option<f64> {
        self.full.filter(|full| !self.zero || mean > 0.5 * full)
    }
}

/// Returns the mean of max(0, x), its derivative by `mean`, and its variance, for a normal x with
/// this mean and the standard deviation `sigma` > 0.
pub(crate) fn clipped(mean: f64, sigma: f64) -> (f64, f64, f64) {
    let z = mean / sigma;
    // Beyond 8 sigma fewer than one pixel in 10^15 is cut off.
    if z > 8.0 {
        return (mean, 1.0, sigma * sigma);
    }
    let (above, density) = (above(z), density(z));
    let first = z * above + density;
    let second = (z * z + 1.0) * above + z * density;
    (
        sigma * first,
        above,
        (sigma * sigma * (second - first * first)).max(f64::MIN_POSITIVE),
    )
}

/// Returns the Fisher information of one observation of max(0, x) on the mean, in units of
/// 1/sigma^2. It tends to 1 far above 0.
pub(crate) fn information(mean: f64, sigma: f64) -> f64 {
    let z = mean / sigma;
    if z > 8.0 {
        return 1.0;
    }
    let (above, density) = (above(z), density(z));
    let below = crate::numerics::clip::above(-z);
    above - z * density + density * density / below
}

/// Returns the probability that a standard normal variable exceeds -z.
fn above(z: f64) -> f64 {
    0.5 * libm::erfc(-z / SQRT_2)
}

fn density(z: f64) -> f64 {
    (-0.5 * z * z).exp() / (2.0 * PI).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares a cut at 0 and at full scale with sums over a fine grid of the normal density,
    /// whose error is that of `moments_meet_quadrature`.
    #[test]
    fn both_limits_cut_what_lies_beyond() {
        let cut = Cut {
            zero: true,
            full: Some(1.0),
        };
        let (sigma, step) = (0.05, 1e-3);
        for mean in [-0.02, 0.0, 0.03, 0.5, 0.93, 0.99, 1.0, 1.02] {
            let (mut sum, mut square) = (0.0, 0.0);
            for i in -10_000..=10_000 {
                let x = f64::from(i) * step;
                let value = (mean + sigma * x).clamp(0.0, 1.0);
                sum += density(x) * step * value;
                square += density(x) * step * value * value;
            }
            let (found, slope, variance) = cut.clipped(mean, sigma);
            assert!((found - sum).abs() < 1e-6 * sigma, "{mean}: {found} {sum}");
            let expected = square - sum * sum;
            assert!((variance - expected).abs() < 1e-5 * sigma * sigma, "{mean}");
            let h = 1e-5;
            let [low, high] = [mean - h, mean + h].map(|mean| cut.clipped(mean, sigma).0);
            assert!((slope - (high - low) / (2.0 * h)).abs() < 1e-6, "{mean}");
        }
        // Both limits are alike: the information at full scale is that at 0.
        let mirrored = (cut.information(0.99, sigma), cut.information(0.01, sigma));
        assert!((mirrored.0 - mirrored.1).abs() < 1e-12, "{mirrored:?}");
    }

    /// A pixel feels the limit that is nearer, whatever the full scale. The two limits are mirror
    /// images of each other, so the means differ from their limits by the same numbers.
    #[test]
    fn a_pixel_feels_the_nearer_limit() {
        let mut cases = 0;
        for full in [0.125, 1.0, 8.0] {
            let cut = Cut {
                zero: true,
                full: Some(full),
            };
            for part in [0.0, 0.125, 0.375] {
                let (mean, sigma) = (part * full, 0.25 * full);
                let expected @ (below, slope, variance) = clipped(mean, sigma);
                assert_eq!(cut.clipped(mean, sigma), expected, "{full} {part}");
                let mirrored = (full - below, slope, variance);
                assert_eq!(cut.clipped(full - mean, sigma), mirrored, "{full} {part}");
                cases += 2;
            }
        }
        assert_eq!(cases, 18);
    }

    /// Compares with sums over a fine grid of the normal density: 2e4 points over +-10 sigma. Their
    /// error is below rounding for a smooth integrand, and step^2 / 8 = 1.3e-7 at the kink.
    #[test]
    fn moments_meet_quadrature() {
        for (mean, sigma) in [(-1.0, 0.7), (0.0, 1.0), (0.4, 0.5), (2.0, 1.0), (9.0, 1.0)] {
            let step = 1e-3;
            let (mut sum, mut square, mut score) = (0.0, 0.0, 0.0);
            let mut below = 0.0;
            for i in -10_000..=10_000 {
                let x = f64::from(i) * step;
                let weight = density(x) * step;
                let value: f64 = mean + sigma * x;
                sum += weight * value.max(0.0);
                square += weight * value.max(0.0).powi(2);
                if value > 0.0 {
                    score += weight * x * x;
                } else {
                    below += weight;
                }
            }
            let (m, slope, variance) = clipped(mean, sigma);
            assert!((m - sum).abs() < 1e-6, "{mean} {sigma}: mean {m} {sum}");
            assert!(
                (variance - (square - sum * sum)).abs() < 1e-5,
                "{mean} {sigma}"
            );
            let h = 1e-5;
            let difference = (clipped(mean + h, sigma).0 - clipped(mean - h, sigma).0) / (2.0 * h);
            assert!((slope - difference).abs() < 1e-8, "{mean} {sigma}");
            // The score of an observation that is cut off is -density / probability.
            if below > 0.0 {
                score += density(mean / sigma).powi(2) / below;
            }
            let found = information(mean, sigma);
            // `below` is a sum that ends inside the density, so it is off by half a step of the
            // density.
            assert!(
                (found - score).abs() < 1e-3,
                "{mean} {sigma}: {found} {score}"
            );
        }
    }
}
