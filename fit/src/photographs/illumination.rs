//! Uneven light: vignetting and gradients of the source, found beside the edge and divided out.
//!
//! The light is taken for 1 + g1 s + g2 t + g3 (s^2 + t^2), with s the distance from the edge and t
//! the place along it: a factor on everything, as vignetting and an uneven source are, with the one
//! curvature that a lens has. An edge is the same all along t, so g2 and g3 show in pixels of equal
//! s (on the plateaus: a bowed edge looks alike). Along s light and blur are told apart by
//! symmetry: about its middle a blurred edge is odd, however far its tails reach, and g1 adds an
//! even part, (step/2) g1 |s|. What is even in the blur itself (coma) is left out with the middle
//! quarter of the profile.

use nalgebra::{Matrix2, Vector2};

use crate::photographs::edge::line::EdgeLine;
use crate::photographs::profile::{BIN_PX, Profile};
use crate::photographs::window::{Pixel, Window};

/// Least unevenness over the window that is corrected: the asymmetric halo of a real lens looks
/// like as much.
const LEAST: f64 = 0.01;

/// Fall of chi-square (3 terms) from which unevenness is believed: noise reaches it once in 10^10
/// photographs.
const BELIEVED: f64 = 50.0;

/// The light about an edge, 1 on the edge abreast of the window's centre. Lengths in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Light {
    line: EdgeLine,
    /// Of s, t and s^2 + t^2.
    terms: [f64; 3],
}

impl Light {
    /// The light at a pixel.
    pub(crate) fn at(&self, pixel: &Pixel) -> f64 {
        let (s, t) = self.line.place(pixel);
        let [across, along, curvature] = self.terms;
        1.0 + across * s + along * t + curvature * (s * s + t * t)
    }
}

/// Largest over smallest light in the window, less 1, where several lights multiply; infinite where
/// one falls to 0.
pub(crate) fn unevenness(lights: &[Light], window: &Window) -> f64 {
    let (mut low, mut high) = (1.0_f64, 1.0_f64);
    for pixel in window.outline() {
        let light: f64 = lights
            .iter()
            .map(|light| light.at(&pixel).max(0.0))
            .product();
        (low, high) = (low.min(light), high.max(light));
    }
    high / low - 1.0
}

/// Finds the light of a window, where it is uneven beyond noise and doubt; `None` where it is even.
pub(crate) fn find(window: &Window, line: &EdgeLine, profile: &Profile) -> Option<Light> {
    let ([g2, g3], fall_along) = along(window, line, profile)?;
    let (g1, fall_across) = across(profile, g3);
    let light = Light {
        line: *line,
        terms: [g1, g2, g3],
    };
    (fall_along + fall_across > BELIEVED && unevenness(&[light], window) > LEAST).then_some(light)
}

/// Moments of the pixels of one bin; t is in units of the window's half diagonal, r is the distance
/// from the profile.
#[derive(Clone, Copy, Default)]
struct Bin {
    n: f64,
    t: [f64; 4],
    r: f64,
    rt: [f64; 2],
}

/// g2 and g3, and the fall of chi-square that they bring: within each bin of equal s the pixels are
/// regressed on level x (t, t^2).
fn along(window: &Window, line: &EdgeLine, profile: &Profile) -> Option<([f64; 2], f64)> {
    let unit = 0.5 * (window.width() as f64).hypot(window.height() as f64);
    let mut bins = vec![Bin::default(); profile.len()];
    for pixel in window.pixels() {
        let (s, t) = line.place(&pixel);
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
    let terms = normal.try_inverse()? * right;
    Some((
        [terms[0] / unit, terms[1] / (unit * unit)],
        terms.dot(&right),
    ))
}

/// g1, and the fall of chi-square that it brings, from the even part of the profile less that of
/// `curvature`.
fn across(profile: &Profile, curvature: f64) -> (f64, f64) {
    let (dark, bright) = profile.plateaus();
    let (middle, half_step) = (0.5 * (dark + bright), 0.5 * (bright - dark));
    let reach = profile.reach;
    // Weighted sums of 1, |s|, s^2, the even part, and its product with |s|.
    let mut sums = [0.0; 5];
    for k in reach / 4..=reach {
        let (low, high) = (reach - k, reach + k);
        if profile.count[low] == 0.0 || profile.count[high] == 0.0 {
            continue;
        }
        let s = k as f64 * BIN_PX;
        let even = 0.5 * (profile.mean[low] + profile.mean[high]) - middle * curvature * s * s;
        let weight = 4.0 / (profile.variance[low] + profile.variance[high]);
        let terms = [1.0, s, s * s, even, even * s];
        sums.iter_mut()
            .zip(terms)
            .for_each(|(sum, x)| *sum += weight * x);
    }
    let [w, ws, wss, e, es] = sums;
    let (spread, product) = (wss - ws * ws / w, es - e * ws / w);
    let slope = product / spread;
    (slope / half_step, slope * product)
}
