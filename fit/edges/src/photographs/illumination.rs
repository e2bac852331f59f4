//! Correction of uneven light (vignetting, gradients of the source): it is found beside the edge.
//!
//! The light is a factor on everything, as vignetting and an uneven source are: 1 + g1 s + g2 t +
//! g3 (s^2 + t^2). s is the distance from the edge and t the place along it. It has one curvature,
//! as a lens has. Light that falls far is the exponential of these terms. On real photographs a
//! curvature of its own across the edge, or a twist, takes the asymmetric tails of a blur for light
//! of 100 % and more.
//!
//! - g2 and g3: an edge is the same all along t, so both show in pixels of equal s. Only pixels on
//!   the plateaus are used, because a bowed edge has the same effect near the edge.
//! - g1: along s, light and blur are told apart by symmetry. About its middle a blurred edge is
//!   odd, however far its tails reach. g1 adds an even part, s times the odd part of the edge. The
//!   blur itself may have an even part (coma); it is left out with the middle quarter of the
//!   profile.

use nalgebra::{Matrix2, Vector2};

use crate::numerics::factor;
use crate::numerics::factor::Products;
use crate::photographs::edge::line::EdgeLine;
use crate::photographs::profile::{BIN_PX, Profile};
use crate::photographs::window::{Pixel, Window};

/// Least unevenness over the window that is corrected. The asymmetric halo of a real lens can look
/// like unevenness of this size.
const LEAST: f64 = 0.01;

/// Least fall of chi-square (3 terms) for which unevenness is corrected. Noise reaches it once in
/// 10^10 photographs.
const BELIEVED: f64 = 50.0;

/// Least light down to which it is a polynomial. Light that falls lower is the exponential of the
/// polynomial's change: terms that are known to first order alone may fall below 0 in a corner.
const LOWEST: f64 = 0.7;

/// The light about an edge. It is 1 on the edge abreast of the window's centre. Lengths are in
/// pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Light {
    line: EdgeLine,
    /// Coefficients of s, t and s^2 + t^2.
    terms: [f64; 3],
    /// True if the light is an exponential.
    is_steep: bool,
}

impl Light {
    /// Returns the light at a pixel.
    pub(crate) fn at(&self, pixel: &Pixel) -> f64 {
        let (s, t) = self.line.place(pixel);
        let [by_s, by_t, curvature] = self.terms;
        let change = by_s * s + by_t * t + curvature * (s * s + t * t);
        if self.is_steep {
            change.exp()
        } else {
            1.0 + change
        }
    }
}

/// Returns the ratio of the largest to the smallest light in the window, less 1. Several lights
/// multiply.
pub(crate) fn unevenness(lights: &[Light], window: &Window) -> f64 {
    let (mut low, mut high) = (1.0_f64, 1.0_f64);
    for pixel in window.outline() {
        let light: f64 = lights.iter().map(|light| light.at(&pixel)).product();
        (low, high) = (low.min(light), high.max(light));
    }
    high / low - 1.0
}

/// Finds the light of a window. Returns `None` if the light is even, or if noise explains the
/// unevenness.
pub(crate) fn find(window: &Window, line: &EdgeLine, profile: &Profile) -> Option<Light> {
    let (profile, [by_t, curvature], fall_along) = along(window, line, profile)?;
    let (by_s, fall_across) = across(&profile, curvature);
    let mut light = Light {
        line: *line,
        terms: [by_s, by_t, curvature],
        is_steep: false,
    };
    light.is_steep = window.outline().any(|pixel| light.at(&pixel) < LOWEST);
    (fall_along + fall_across > BELIEVED && unevenness(&[light], window) > LEAST).then_some(light)
}

/// Moments of the pixels of one bin. t is in units of the window's half diagonal, r is the distance
/// from the profile.
#[derive(Clone, Copy, Default)]
struct Bin {
    n: f64,
    t: [f64; 4],
    r: f64,
    rt: [f64; 2],
}

/// Returns the coefficients of t and t^2, and the fall of chi-square that they bring. Within each
/// bin of equal s the pixels are regressed on level x (t, t^2). The profile that is returned is
/// that at t = 0: the bins at its ends hold pixels of one corner of the window.
fn along(window: &Window, line: &EdgeLine, profile: &Profile) -> Option<(Profile, [f64; 2], f64)> {
    let unit = 0.5 * (window.width() as f64).hypot(window.height() as f64);
    let mut bins = vec![Bin::default(); profile.len()];
    let ruler = line.ruler();
    for pixel in window.pixels() {
        let (s, t) = ruler.place(pixel.x, pixel.y);
        let Some(expected) = profile.at(s) else {
            continue;
        };
        let bin = &mut bins[((s / BIN_PX).round() + profile.reach as f64) as usize];
        let (t, r) = (t / unit, pixel.value - expected);
        let mut power = t;
        for moment in &mut bin.t {
            *moment += power;
            power *= t;
        }
        bin.n += 1.0;
        bin.r += r;
        bin.rt[0] += r * t;
        bin.rt[1] += r * t * t;
    }
    let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
    for (j, b) in bins.iter().enumerate() {
        if j.abs_diff(profile.reach) < profile.reach / 4 || b.n < 2.0 {
            continue;
        }
        let level = profile.mean[j];
        let weight = 1.0 / (profile.variance[j] * profile.count[j]).max(f64::MIN_POSITIVE);
        let t2 = b.t[1] - b.t[0] * b.t[0] / b.n;
        let t3 = b.t[2] - b.t[0] * b.t[1] / b.n;
        let t4 = b.t[3] - b.t[1] * b.t[1] / b.n;
        let (rt, rtt) = (b.rt[0] - b.r * b.t[0] / b.n, b.rt[1] - b.r * b.t[1] / b.n);
        normal += Matrix2::new(t2, t3, t3, t4) * (weight * level * level);
        right += Vector2::new(rt, rtt) * (weight * level);
    }
    let terms: Vector2<f64> = normal.try_inverse()? * right;
    let fall = terms.dot(&right);
    let mut at_middle = profile.clone();
    for (mean, b) in at_middle.mean.iter_mut().zip(&bins) {
        if b.n > 0.0 {
            let light = terms[0] * b.t[0] + terms[1] * b.t[1];
            *mean /= 1.0 + light / b.n;
        }
    }
    let terms = [terms[0] / unit, terms[1] / (unit * unit)];
    Some((at_middle, terms, fall))
}

/// Returns the coefficient of s, and the fall of chi-square that it brings. It comes from the even
/// part of the profile, less its level and the even part that `curvature` makes.
fn across(profile: &Profile, curvature: f64) -> (f64, f64) {
    let (dark, bright) = profile.plateaus();
    let middle = 0.5 * (dark + bright);
    let reach = profile.reach;
    let mut normal = Products::new(3);
    for k in reach / 4..=reach {
        let (low, high) = (reach - k, reach + k);
        if profile.count[low] == 0.0 || profile.count[high] == 0.0 {
            continue;
        }
        let s = k as f64 * BIN_PX;
        let even = 0.5 * (profile.mean[low] + profile.mean[high]);
        let odd = 0.5 * (profile.mean[high] - profile.mean[low]);
        let root = (4.0 / (profile.variance[low] + profile.variance[high])).sqrt();
        let row = [1.0, s * odd, even - middle * (1.0 + curvature * s * s)];
        normal.add(&row.map(|v| v * root));
    }
    let factor = factor::of(normal.sum());
    let terms = factor::back_substituted(&factor, 2, 2);
    (terms[1], factor[(1, 2)].powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photographs::photo::plane::Photo;
    use crate::photographs::photo::taken::Taken;

    /// Light that rises by a hundredth a pixel goes from 0.8 to 1.2 over 41 pixels, a ratio of 1.5;
    /// two such lights multiply. The numbers round by less than 1e-14.
    #[test]
    fn unevenness_is_the_ratio_of_largest_to_smallest_light() {
        let photo = Photo {
            width: 41,
            height: 21,
            luminance: vec![0.5; 41 * 21],
            clip_level: None,
            clips_alone: true,
            transfer: Taken::default(),
            warnings: Vec::new(),
        };
        let window = Window::of(&photo, None).expect("the whole picture");
        let light = Light {
            line: EdgeLine {
                normal_rad: 0.0,
                offset_px: 0.0,
                normal_standard_error_rad: 0.0,
                bend: None,
            },
            terms: [0.01, 0.0, 0.0],
            is_steep: false,
        };
        for (lights, expected) in [
            (vec![], 0.0),
            (vec![light], 0.5),
            (vec![light, light], 1.25),
        ] {
            let found = unevenness(&lights, &window);
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        }
    }
}
