//! Distributions of the slopes of rough facets, and their Fourier transforms.
//!
//! The normal of a facet n + s has the slope s = (s_x, s_y). With z = s / alpha, where alpha is the
//! roughness:
//!
//! - Beckmann: density exp(-z^2) / pi, transform exp(-k^2 / 4).
//! - GGX (Trowbridge-Reitz; Walter et al. 2007): density 1 / (pi (1 + z^2)^2), transform k K1(k),
//!   whose derivative is -k K0(k). The second moment diverges logarithmically.
//!
//! The function D(h) of a renderer is this density of slopes over cos^4 of the normal's angle. That
//! factor is 1 to second order.

/// Evaluates the transform of Beckmann's density at k >= 0, and its derivative.
pub fn beckmann(k: f64) -> (f64, f64) {
    let value = (-0.25 * k * k).exp();
    (value, -0.5 * k * value)
}

/// Evaluates the transform of the GGX density at k >= 0, and its derivative. The accuracy is 3e-7.
/// K0 and K1 follow Abramowitz and Stegun, 9.8.5 to 9.8.8, with I0 and I1 by 9.8.1 and 9.8.3.
pub fn ggx(k: f64) -> (f64, f64) {
    if k == 0.0 {
        return (1.0, 0.0);
    }
    let (k0, k1) = if k <= 2.0 {
        let (y, t) = (0.25 * k * k, (k / 3.75).powi(2));
        let log = (0.5 * k).ln();
        let i0 = polynomial(&I0, t);
        let i1_over_k = polynomial(&I1, t);
        (
            polynomial(&K0_SMALL, y) - log * i0,
            polynomial(&K1_SMALL, y) / k + log * k * i1_over_k,
        )
    } else {
        let scale = (-k).exp() / k.sqrt();
        let y = 2.0 / k;
        (
            scale * polynomial(&K0_LARGE, y),
            scale * polynomial(&K1_LARGE, y),
        )
    };
    (k * k1, -k * k0)
}

/// Returns the quantile of the distance from the middle, of the distribution function 1 -
/// exp(-z^2).
pub(super) fn beckmann_radius(share: f64) -> f64 {
    (-(-share).ln_1p()).sqrt()
}

/// Returns the quantile of the distance from the middle, of the distribution function 1 - 1 / (1 +
/// z^2).
pub(super) fn ggx_radius(share: f64) -> f64 {
    (share / (1.0 - share)).sqrt()
}

/// Returns the distance beyond which at most the share `tail` lies along a line: a normal
/// distribution of variance 1/2 has the share erfc(x) < exp(-x^2) beyond x.
pub(super) fn beckmann_reach(tail: f64) -> f64 {
    (-tail.ln()).sqrt()
}

/// Returns the distance beyond which the share `tail` lies along a line, where GGX is Student's t:
/// the share 1 - x / sqrt(x^2 + 1) = 1 / (2 x^2) lies beyond x.
pub(super) fn ggx_reach(tail: f64) -> f64 {
    (0.5 / tail).sqrt()
}

fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

const I0: [f64; 7] = [
    1.0,
    3.515_622_9,
    3.089_942_4,
    1.206_749_2,
    0.265_973_2,
    0.036_076_8,
    0.004_581_3,
];
const I1: [f64; 7] = [
    0.5,
    0.878_905_94,
    0.514_988_69,
    0.150_849_34,
    0.026_587_33,
    0.003_015_32,
    0.000_324_11,
];
const K0_SMALL: [f64; 7] = [
    -0.577_215_66,
    0.422_784_2,
    0.230_697_56,
    0.034_885_9,
    0.002_626_98,
    0.000_107_5,
    0.000_007_4,
];
const K1_SMALL: [f64; 7] = [
    1.0,
    0.154_431_44,
    -0.672_785_79,
    -0.181_568_97,
    -0.019_194_02,
    -0.001_104_04,
    -0.000_046_86,
];
const K0_LARGE: [f64; 7] = [
    1.253_314_14,
    -0.078_323_58,
    0.021_895_68,
    -0.010_624_46,
    0.005_878_72,
    -0.002_515_4,
    0.000_532_08,
];
const K1_LARGE: [f64; 7] = [
    1.253_314_14,
    0.234_986_19,
    -0.036_556_2,
    0.015_042_68,
    -0.007_803_53,
    0.003_256_14,
    -0.000_682_45,
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    /// Integrates the Hankel transform of a density of slopes to z = 4000, by the midpoint rule in
    /// ln z.
    fn hankel(density: impl Fn(f64) -> f64, k: f64) -> f64 {
        let (first, last, n) = (1e-5_f64.ln(), 4000.0_f64.ln(), 2_000_000);
        let h = (last - first) / n as f64;
        (0..n)
            .map(|i| {
                let z = (first + (i as f64 + 0.5) * h).exp();
                TAU * z * z * density(z) * libm::j0(k * z) * h
            })
            .sum()
    }

    #[test]
    fn transforms_are_those_of_the_densities_which_hold_all_light() {
        for k in [0.0, 0.01, 0.3, 1.0, 1.99, 2.01, 3.5, 6.0] {
            // Beyond z = 4000 GGX holds 1/4000^2 = 6e-8 of the light. Below z = 1e-5 both densities
            // hold 1e-10. Abramowitz and Stegun state 2e-7.
            let gaussian = hankel(|z| (-z * z).exp() / PI, k);
            let heavy = hankel(|z| (1.0 + z * z).powi(-2) / PI, k);
            assert!((beckmann(k).0 - gaussian).abs() < 1e-8, "beckmann {k}");
            assert!((ggx(k).0 - heavy).abs() < 3e-7, "ggx {k}: {heavy}");
        }
    }

    #[test]
    fn bessel_functions_are_their_integrals_and_derivatives_are_differences() {
        // K_n(x) = int_0^inf exp(-x cosh t) cosh(n t) dt. The trapezoidal rule converges as
        // exp(-pi^2 / h).
        let integral = |x: f64, n: f64| {
            let h = 0.05;
            let term = |i: i32| {
                let t = f64::from(i) * h;
                (-x * t.cosh()).exp() * (n * t).cosh() * h
            };
            0.5 * term(0) + (1..400).map(term).sum::<f64>()
        };
        for k in [1e-4, 0.02, 0.5, 1.3, 1.999, 2.001, 4.0, 9.0, 30.0] {
            let (value, slope) = ggx(k);
            // By 9.8.7 the error of k K1 is below 8e-9 for k < 2, and below 2.2e-7 / sqrt(k) e^-k k
            // above.
            assert!((value - k * integral(k, 1.0)).abs() < 3e-7, "K1 at {k}");
            assert!((slope + k * integral(k, 0.0)).abs() < 3e-7, "K0 at {k}");
            let d = 1e-4 * k.max(1e-2);
            let difference = (ggx(k + d).0 - ggx(k - d).0) / (2.0 * d);
            // Two errors add. The truncation is d^2 |f'''| / 6, with f''' of order 1/k below 1. The
            // approximations jump by 1e-8, which is divided by 2 d.
            let tolerance = d * d / k.min(1.0) + 4e-8 / d;
            assert!(
                (slope - difference).abs() < tolerance,
                "{k}: {slope} {difference}"
            );
            let difference = (beckmann(k + d).0 - beckmann(k - d).0) / (2.0 * d);
            assert!((beckmann(k).1 - difference).abs() < d * d + 1e-15 / d);
        }
    }
}
