//! Rough facets: at each reflection the ray meets a normal that is drawn from the slopes of the
//! facet, as the ray sees them.
//!
//! A facet's small mirrors have the normals n - s, s their slope. Per unit of the roughness alpha,
//! z = |s| / alpha, the densities of slopes are exp(-z^2) / pi (Beckmann; alpha is sqrt 2 times the
//! rms slope) and 1 / (pi (1 + z^2)^2) (GGX). From the direction w a mirror is seen in proportion
//! to its projected area, max(0, w.(n - s)): that is the density of **visible normals** (Heitz and
//! d'Eon 2014) that is drawn here, GGX by the spherical caps of Dupuy and Benyoub (2023), Beckmann
//! by inverting the cumulative distribution of the slope towards the light, which `seen_slope` does
//! to rounding.
//!
//! Single scattering: what is reflected to behind the facet's plane meets the facet again in truth,
//! and counts as absorbed here; that light on its way out may meet other small mirrors of the facet
//! is left out. Both matter only where the cosine of the light's angle from the facet's normal is
//! not large against alpha.

use crate::samples::centred;
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_2_SQRT_PI, PI, SQRT_2, TAU};
use tables::options::{Roughness, Slopes};

/// The unit normal that a ray along `travel` meets on a facet with unit normal `facet`, towards the
/// ray; `at` are two coordinates that are uniform over [0, 2^32).
pub(crate) fn normal(roughness: &Roughness, facet: DVec3, travel: DVec3, at: [u32; 2]) -> DVec3 {
    let cosine = -facet.dot(travel);
    let along = -travel - facet * cosine;
    let sine = along.length();
    // Nearer to the normal what is along the facet is rounding, and the side that it leans to makes
    // no difference.
    let x = if sine > 1e-8 {
        along / sine
    } else {
        facet.any_orthonormal_vector()
    };
    // Stretched to alpha = 1 the facet is as rough, and the light comes from elsewhere.
    let light = DVec2::new(roughness.alpha() * sine, cosine).normalize();
    let [u, v] = at.map(|cell| centred(cell) + 0.5);
    let slope = roughness.alpha() * seen_from(roughness.slopes(), light, u, v);
    (facet - x * slope.x - facet.cross(x) * slope.y).normalize()
}

/// The angle that hardly any light of three perpendicular facets turns by more than, rad: 8
/// standard deviations about each axis of what Beckmann's slopes do; of GGX's, whose tails have no
/// end, what leaves 0.7 % outside.
pub(crate) fn reach_rad(roughness: &Roughness) -> f64 {
    match roughness.slopes() {
        Slopes::Beckmann => 8.0 * roughness.alpha(),
        Slopes::Ggx => 40.0 * roughness.alpha(),
    }
}

/// About which part of the light that three perpendicular facets send back turns by more than
/// `tolerance_rad`.
///
/// A slope s turns light by 2 s about an axis in the facet. Of three perpendicular facets two turn
/// about each axis: Beckmann's turns are a Gaussian of the variance 4 alpha^2 about each; of GGX's
/// long tails one of three is large.
pub(crate) fn part_beyond(roughness: &Roughness, tolerance_rad: f64) -> f64 {
    let turns = tolerance_rad / (2.0 * roughness.alpha());
    match roughness.slopes() {
        Slopes::Beckmann => {
            let bulk = FRAC_2_SQRT_PI / SQRT_2 * turns * libm::exp(-0.5 * turns * turns);
            libm::erfc(turns / SQRT_2) + bulk
        }
        Slopes::Ggx => (3.0 / (1.0 + turns * turns)).min(1.0),
    }
}
/// A slope of unit roughness seen from `light` = (sine, cosine) of the angle from the facet's
/// normal, its first coordinate towards the light; `u` and `v` in (0, 1) choose it.
fn seen_from(slopes: Slopes, light: DVec2, u: f64, v: f64) -> DVec2 {
    let DVec2 { x: sine, y: cosine } = light;
    match slopes {
        Slopes::Beckmann => DVec2::new(seen_slope(sine, cosine, u), seen_slope(0.0, 1.0, v)),
        Slopes::Ggx => {
            let z = (1.0 - v) * (1.0 + cosine) - cosine;
            let ring = (1.0 - z * z).max(0.0).sqrt();
            let (sin, cos) = libm::sincos(TAU * u);
            -DVec2::new(ring * cos + sine, ring * sin) / (z + cosine)
        }
    }
}
/// The slope towards the light, of Beckmann's of unit roughness, below which the part `part` of
/// what is seen lies.
///
/// Slopes x are seen in proportion to (cosine - x sine) exp(-x^2), up to x = cosine / sine, where
/// mirrors turn away. Newton's method on the integral, halving where it would leave the bracket.
fn seen_slope(sine: f64, cosine: f64, part: f64) -> f64 {
    // 1 / (2 sqrt pi)
    const HALF: f64 = 0.25 * FRAC_2_SQRT_PI;
    let below = |x: f64| 0.5 * cosine * libm::erfc(-x) + HALF * sine * libm::exp(-x * x);
    let most = cosine / sine;
    let sought = part * below(most);
    // 2^-33 of the light lies beyond 4.8.
    let (mut low, mut high) = (-6.0, most.min(6.0));
    // Winitzki's approximation of the inverse error function, good to 2e-3: where the light would
    // come from the normal.
    let log = libm::log(4.0 * part * (1.0 - part));
    let half = 2.0 / (PI * 0.147) + 0.5 * log;
    let upright = ((half * half - log / 0.147).sqrt() - half).max(0.0).sqrt();
    let mut x = upright.copysign(part - 0.5).min(high);
    for _ in 0..100 {
        let excess = below(x) - sought;
        if excess > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let newton = x - excess / (2.0 * HALF * (cosine - x * sine) * libm::exp(-x * x));
        let inside = newton > low && newton < high;
        // The error squares with each step.
        if inside && (newton - x).abs() < 1e-8 {
            return newton;
        }
        x = if inside {
            newton
        } else {
            f64::midpoint(low, high)
        };
    }
    x
}
