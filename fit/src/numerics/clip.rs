//! A normal variable cut off at 0, as a camera without a black offset cuts off its noise.

use std::f64::consts::{PI, SQRT_2};

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

    /// Compares with sums over a fine grid of the normal density: 2e4 points over +-10 sigma. Their
    /// error is below rounding for a smooth integrand, and step^2 / 8 = 1.3e-7 at the kink.
    #[test]
    fn moments_meet_quadrature() {
        let mut cases = 0;
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
            cases += 1;
        }
        assert_eq!(cases, 5);
    }
}
