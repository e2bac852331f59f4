//! Lobes: what each shape does to light, by its transfer function and by samples.
//!
//! Eq. (1) of Sugawara and Koizumi (SIGGRAPH Asia 2025 Posters) gives the diffraction lobe as
//! sinc^2(a r) of the lateral offset r = R tan(theta_o - theta_i), with sinc t = sin t / t. The
//! paper leaves open whether it is cut, and what it is in two dimensions. A scene chooses: `radial`
//! or `separable`.
//!
//! `gaussian` is not in the paper. Its density is exp(-(a r)^2) a^2 / pi, and its OTF
//! exp(-(pi f / a)^2) = exp(-2 pi^2 sigma^2 f^2) with the standard deviation sigma = 1 / (sqrt(2) a)
//! along each axis. So 1/a is a radius as it is in Eq. (1), where the light has fallen to 1/e
//! instead of sin^2(1) = 0.71. This is the curve of Beckmann's facets with the roughness 1/a.
//!
//! The lobes of rough facets (`microfacet`) are here too, for the baselines.
//!
//! A shape has one file with its mathematics for a = 1, and one line in each match below.
//! CONTRIBUTING.md lists what else a new one needs.

pub mod microfacet;
mod radial;
mod separable;

use std::f64::consts::{PI, TAU};

use edges::names::LobeShape;

pub use radial::CUT;

/// What the shape of a lobe does to light.
pub trait Lobe {
    /// Evaluates the OTF and its derivative by a, at `frequency` (1/mm) along the unit direction
    /// `normal` (tangential, sagittal), for `a` in 1/mm.
    ///
    /// The OTF is real, and 1 at frequency 0. Its accuracy is 2e-6 (radial, see `radial`), 3e-7
    /// (ggx) and rounding (separable, gaussian, beckmann).
    fn otf(self, a: f64, frequency: f64, normal: [f64; 2]) -> (f64, f64);

    /// Returns an offset (tangential, sagittal) of the lobe with a = 1 for a point of the unit
    /// square. Evenly spread points give offsets that are distributed as the light.
    ///
    /// The distribution function of each shape is inverted. Those of the facets are 1 - exp(-r^2)
    /// and 1 - 1 / (1 + r^2). Those of `radial` and `separable` are tables, whose cells are so fine
    /// that the OTF of the samples agrees with that of the lobe to 2e-5 (a density that is even over
    /// cells of width h adds h^2 / 12 to the variance of the lobe).
    fn offset(self, point: [f64; 2]) -> [f64; 2];

    /// Returns the distance that holds all but the share `tail` of the light along each axis, mm.
    /// `tail` must be far below 1.
    fn reach_mm(self, a: f64, tail: f64) -> f64;

    /// Returns the slope of the OTF at frequency 0, -d OTF/d|f| (mm), and its derivative by a.
    ///
    /// This kink gives an edge its 1/x tails. Only the separable shape has one. The radial lobe has
    /// a finite support, and ggx falls as 1/r^4.
    fn kink(self, a: f64, normal: [f64; 2]) -> (f64, f64);

    /// Returns whether the lobe is the same along every direction.
    fn round(self) -> bool;
}

impl Lobe for LobeShape {
    fn otf(self, a: f64, frequency: f64, normal: [f64; 2]) -> (f64, f64) {
        let round = |transform: fn(f64) -> (f64, f64)| {
            let k = 2.0 * PI * frequency.abs() / a;
            let (value, slope) = transform(k);
            (value, -slope * k / a)
        };
        match self {
            LobeShape::Radial => round(radial::otf),
            LobeShape::Separable => separable::otf(a, frequency, normal),
            LobeShape::Gaussian | LobeShape::Beckmann => round(microfacet::beckmann),
            LobeShape::Ggx => round(microfacet::ggx),
        }
    }

    fn offset(self, [u, v]: [f64; 2]) -> [f64; 2] {
        let round = |radius: f64| {
            let (sin, cos) = (TAU * v).sin_cos();
            [radius * cos, radius * sin]
        };
        match self {
            LobeShape::Radial => round(radial::radius(u)),
            LobeShape::Separable => [separable::axis(u), separable::axis(v)],
            LobeShape::Gaussian | LobeShape::Beckmann => round(microfacet::beckmann_radius(u)),
            LobeShape::Ggx => round(microfacet::ggx_radius(u)),
        }
    }

    fn reach_mm(self, a: f64, tail: f64) -> f64 {
        match self {
            LobeShape::Radial => CUT / a,
            LobeShape::Separable => separable::reach_mm(a, tail),
            LobeShape::Gaussian | LobeShape::Beckmann => microfacet::beckmann_reach(tail) / a,
            LobeShape::Ggx => microfacet::ggx_reach(tail) / a,
        }
    }

    fn kink(self, a: f64, normal: [f64; 2]) -> (f64, f64) {
        match self {
            LobeShape::Separable => separable::kink(a, normal),
            LobeShape::Radial | LobeShape::Gaussian | LobeShape::Beckmann | LobeShape::Ggx => {
                (0.0, 0.0)
            }
        }
    }

    fn round(self) -> bool {
        match self {
            LobeShape::Radial | LobeShape::Gaussian | LobeShape::Beckmann | LobeShape::Ggx => true,
            LobeShape::Separable => false,
        }
    }
}

/// Integrates a density over cells of width `step` from 0 on, by the two-point Gauss rule, which is
/// exact to step^4.
fn cell_masses(count: usize, step: f64, density: impl Fn(f64) -> f64) -> Vec<f64> {
    let node = 0.5 / 3.0_f64.sqrt();
    (0..count)
        .map(|i| {
            let at = |x: f64| density((i as f64 + x) * step);
            0.5 * step * (at(0.5 - node) + at(0.5 + node))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the curvature of the OTF at 0. Relative to it, the difference errs by (pi d / a)^2 / 2 =
    /// 5e-7 at d = a / 3000, and by the rounding 2e-16 / (pi d / a)^2 = 2e-10.
    #[test]
    fn a_gaussian_has_the_standard_deviation_that_its_a_means() {
        let (a, d) = (3.0, 1e-3);
        for normal in [[1.0, 0.0], [0.6, 0.8]] {
            let curvature = 2.0 * (1.0 - LobeShape::Gaussian.otf(a, d, normal).0) / (d * d);
            let ratio = curvature / (TAU * TAU) / (0.5 / (a * a));
            assert!((ratio - 1.0).abs() < 6e-7, "{ratio}");
        }
    }

    #[test]
    fn derivatives_by_a_match_differences() {
        for shape in LobeShape::ALL {
            for f in [0.05, 0.3, 0.9, 1.2] {
                for angle in [0.0_f64, 0.1, 0.6, 1.5] {
                    let normal = [angle.cos(), angle.sin()];
                    let (a, d) = (4.2, 1e-5);
                    let (value, slope) = shape.otf(a, f, normal);
                    let difference =
                        (shape.otf(a + d, f, normal).0 - shape.otf(a - d, f, normal).0) / (2.0 * d);
                    assert!(
                        (slope - difference).abs() < 1e-5,
                        "{shape:?} {f} {angle}: {slope} {difference}"
                    );
                    assert!(value <= 1.0 && value > -0.05);
                }
            }
        }
    }
}
