//! Rough facets: at each reflection the ray meets a normal that is drawn from the facet's slopes,
//! as the ray sees them.
//!
//! The small mirrors of a facet have the normals n - s, where s is the slope. Per unit of the
//! roughness alpha, with z = |s| / alpha, the density of slopes is exp(-z^2) / pi for Beckmann and
//! 1 / (pi (1 + z^2)^2) for GGX. Beckmann's alpha is sqrt 2 times the rms slope.
//!
//! From the direction w a mirror is seen in proportion to its projected area, max(0, w.(n - s)).
//! This gives the density of **visible normals** (Heitz and d'Eon 2014), from which normals are
//! drawn here. GGX uses the spherical caps of Dupuy and Benyoub (2023). Beckmann chooses between a
//! slope and its opposite. If some mirrors turn away from the light, Beckmann inverts the
//! cumulative distribution of the slope towards the light; `seen_slope` does this to rounding.
//!
//! Light is scattered once. Light that is reflected to behind the facet's plane would meet the
//! facet again; here it counts as absorbed. Light on its way out could meet other small mirrors of
//! the facet; this is left out. Both matter only if the cosine of the light's angle from the
//! facet's normal is not large against alpha.

use crate::geometry::centred;
use crate::optics::elementary::{ln, sin_cos};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_2_SQRT_PI, PI, SQRT_2};
use tables::options::{Roughness, Slopes};

/// Random numbers for one normal: coordinates that are uniform over [0, 2^32).
pub(crate) type NormalDraw = [u32; 3];

/// Draws the unit normal, towards the ray, that a ray along `travel` meets on a facet with the unit
/// normal `facet`.
///
/// The ray comes from the front of the facet. The errors of the elementary functions move the
/// normal by less than 1e-15 alpha.
pub(crate) fn normal(roughness: &Roughness, facet: DVec3, travel: DVec3, at: NormalDraw) -> DVec3 {
    let alpha = roughness.alpha();
    match roughness.slopes() {
        Slopes::Beckmann if turns_away(alpha, facet, travel) => steep(alpha, facet, travel, at),
        Slopes::Beckmann => beckmann(alpha, facet, travel, at),
        Slopes::Ggx => ggx(alpha, facet, travel, at),
    }
}

/// Returns whether the ray could see a small mirror with Beckmann's slopes from behind.
///
/// The slopes drawn are at most sqrt(ln 2^33) = 4.79 alpha.
#[inline(always)]
pub(crate) fn turns_away(alpha: f64, facet: DVec3, travel: DVec3) -> bool {
    let cosine = facet.dot(travel);
    let square = cosine * cosine;
    23.0 * (alpha * alpha) * (1.0 - square) > square
}

/// Draws a normal as [`normal`] does, for Beckmann's slopes that all face the ray.
///
/// A slope s and its opposite are drawn with the same density. Together they are seen as 2 cos,
/// whatever s. So a slope is drawn by the method of Box and Muller, and then the third number
/// chooses between it and its opposite, in proportion to what is seen of each.
#[inline(always)]
pub(crate) fn beckmann(alpha: f64, facet: DVec3, travel: DVec3, at: NormalDraw) -> DVec3 {
    let [radius, turn, coin] = at;
    let square = -ln(uniform(radius));
    let (sin, cos) = sin_cos(turn);
    let length = alpha * square.sqrt();
    let slope = along(facet, length * cos, length * sin);
    let cosine = -facet.dot(travel);
    let seen = cosine + slope.dot(travel);
    let keeps = uniform(coin) * (2.0 * cosine) < seen;
    let slope = slope * if keeps { 1.0 } else { -1.0 };
    (facet - slope) * (1.0 / (1.0 + alpha * alpha * square).sqrt())
}

/// Draws a normal as [`normal`] does, for GGX.
///
/// Stretched to alpha = 1, the normals lie half way between the light and the points of a cap of
/// the unit sphere.
#[inline(always)]
pub(crate) fn ggx(alpha: f64, facet: DVec3, travel: DVec3, at: NormalDraw) -> DVec3 {
    let [turn, height, _] = at;
    let [s, t] = axes(facet);
    let [x, y, cosine] = [
        -alpha * travel.dot(s),
        -alpha * travel.dot(t),
        -travel.dot(facet),
    ];
    let unit = 1.0 / (x * x + y * y + cosine * cosine).sqrt();
    let [x, y, cosine] = [x * unit, y * unit, cosine * unit];
    let z = (1.0 - uniform(height)) * (1.0 + cosine) - cosine;
    let inside = 1.0 - z * z;
    let ring = if inside > 0.0 { inside } else { 0.0 }.sqrt();
    let (sin, cos) = sin_cos(turn);
    let [x, y, z] = [
        alpha * (ring * cos + x),
        alpha * (ring * sin + y),
        z + cosine,
    ];
    let mixed = facet * z + s * x + t * y;
    mixed * (1.0 / (x * x + y * y + z * z).sqrt())
}

/// Draws a normal as [`normal`] does, for Beckmann's slopes of any steepness.
#[cold]
pub(crate) fn steep(alpha: f64, facet: DVec3, travel: DVec3, at: NormalDraw) -> DVec3 {
    let cosine = -facet.dot(travel);
    let across = -travel - facet * cosine;
    let sine = across.length();
    let x = across / sine;
    // Stretched to alpha = 1, the facet has unit roughness and the light comes from another
    // direction.
    let light = DVec2::new(alpha * sine, cosine).normalize();
    let toward = alpha * seen_slope(light.x, light.y, uniform(at[0]));
    let beside = alpha * seen_slope(0.0, 1.0, uniform(at[1]));
    (facet - x * toward - facet.cross(x) * beside).normalize()
}

/// Returns the middle of cell `cell` of [0, 1) cut in 2^32.
#[inline(always)]
fn uniform(cell: u32) -> f64 {
    centred(cell) + 0.5
}

/// Returns two unit vectors that are perpendicular to the unit vector `normal` and to each other
/// (Duff et al. 2017).
#[inline(always)]
fn axes(normal: DVec3) -> [DVec3; 2] {
    let DVec3 { x, y, z } = normal;
    let sign = 1.0_f64.copysign(z);
    let a = -1.0 / (sign + z);
    let b = x * y * a;
    [
        DVec3::new(1.0 + sign * x * x * a, sign * b, -sign * x),
        DVec3::new(b, sign + y * y * a, -y),
    ]
}

/// Returns the vector with the components x and y along the [`axes`] of `normal`.
#[inline(always)]
fn along(normal: DVec3, x: f64, y: f64) -> DVec3 {
    let [s, t] = axes(normal);
    s * x + t * y
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
