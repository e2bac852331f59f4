//! Rough facets: at each reflection the ray meets a normal that is drawn from the facet's slopes,
//! as the ray sees them.
//!
//! The small mirrors of a facet have the normals n - s, where s is the slope. Per unit of the
//! roughness alpha, with z = |s| / alpha, the density of slopes is exp(-z^2) / pi for Beckmann and
//! 1 / (pi (1 + z^2)^2) for GGX. Beckmann's alpha is sqrt 2 times the rms slope.
//!
//! From the direction w a mirror is seen in proportion to its projected area, max(0, w.(n - s)).
//! This gives the density of **visible normals** (Heitz and d'Eon 2014), from which normals are
//! drawn here. GGX uses the spherical caps of Dupuy and Benyoub (2023). Beckmann inverts the
//! cumulative distribution of the slope towards the light; `seen_slope` does this to rounding.
//!
//! Light is scattered once. Light that is reflected to behind the facet's plane would meet the
//! facet again; here it counts as absorbed. Light on its way out could meet other small mirrors of
//! the facet; this is left out. Both matter only if the cosine of the light's angle from the
//! facet's normal is not large against alpha.

use crate::samples::centred;
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_2_SQRT_PI, PI, SQRT_2, TAU};
use tables::options::{Roughness, Slopes};

/// Draws the unit normal, towards the ray, that a ray along `travel` meets on a facet with the unit
/// normal `facet`.
///
/// `at` are two coordinates that are uniform over [0, 2^32).
pub(crate) fn normal(roughness: &Roughness, facet: DVec3, travel: DVec3, at: [u32; 2]) -> DVec3 {
    let cosine = -facet.dot(travel);
    let along = -travel - facet * cosine;
    let sine = along.length();
    // Nearer to the normal, the part along the facet is rounding, and its direction makes no
    // difference.
    let x = if sine > 1e-8 {
        along / sine
    } else {
        facet.any_orthonormal_vector()
    };
    // Stretched to alpha = 1, the facet has unit roughness and the light comes from another
    // direction.
    let light = DVec2::new(roughness.alpha() * sine, cosine).normalize();
    let [u, v] = at.map(|cell| centred(cell) + 0.5);
    let slope = roughness.alpha() * seen_from(roughness.slopes(), light, u, v);
    (facet - x * slope.x - facet.cross(x) * slope.y).normalize()
}

/// Returns the angle, rad, by which hardly any light of three perpendicular facets is turned more.
///
/// For Beckmann's slopes it is 8 standard deviations about each axis. GGX has endless tails; 0.7 %
/// of its light lies outside.
pub(crate) fn reach_rad(roughness: &Roughness) -> f64 {
    match roughness.slopes() {
        Slopes::Beckmann => 8.0 * roughness.alpha(),
        Slopes::Ggx => 40.0 * roughness.alpha(),
    }
}

/// Estimates the share of the light that three perpendicular facets send back turned by more than
/// `tolerance_rad`.
///
/// A slope s turns light by 2 s about an axis in the facet. Of three perpendicular facets two turn
/// light about each axis. Beckmann's turns are a Gaussian of the variance 4 alpha^2 about each
/// axis. For the long tails of GGX, one large slope of the three decides.
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
/// Draws a slope of unit roughness as seen from `light`, the (sine, cosine) of its angle from the
/// facet's normal.
///
/// The first coordinate of the slope points towards the light. `u` and `v` in (0, 1) choose the
/// slope.
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
/// Returns the slope towards the light below which the share `part` of what is seen lies, for
/// Beckmann's slopes of unit roughness.
///
/// Slopes x are seen in proportion to (cosine - x sine) exp(-x^2), up to x = cosine / sine, where
/// mirrors turn away. The integral is inverted by Newton's method, with a bisection if a step would
/// leave the bracket.
fn seen_slope(sine: f64, cosine: f64, part: f64) -> f64 {
    // 1 / (2 sqrt pi)
    const HALF: f64 = 0.25 * FRAC_2_SQRT_PI;
    let below = |x: f64| 0.5 * cosine * libm::erfc(-x) + HALF * sine * libm::exp(-x * x);
    let most = cosine / sine;
    let sought = part * below(most);
    // At most 2^-33 of the light lies beyond 4.8.
    let (mut low, mut high) = (-6.0, most.min(6.0));
    // The start is Winitzki's approximation of the inverse error function, good to 2e-3, for light
    // along the normal.
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
        // The error squares with each step, so the next one would be rounding.
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
