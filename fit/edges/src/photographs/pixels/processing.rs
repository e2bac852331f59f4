//! Signs that the camera changed the edge: noise reduction, compression and sharpening.
//!
//! Noise reduction and JPEG leave the noise on an edge, where the light changes, and take it away
//! beside the edge. The noise of a sensor follows the light: on the edge it lies between that of the
//! two plateaus. So the noise on the edge is compared with the straight line between them. Noise is
//! measured by the differences of every second pixel along the edge. Light, waves and a wrong bow of
//! the edge are nearly equal in both and cancel, and so does what demosaicing leaves between pixels
//! that were seen and those that were filled in. Filters that treat all pixels alike (demosaicing, a
//! blur) change all noise by the same factor.
//!
//! Sharpening makes light overshoot beside the edge. A lens cannot: its line spread function is
//! nowhere negative.

use crate::photographs::edge::line::EdgeLine;
use crate::photographs::profile::{BIN_PX, Profile};
use crate::photographs::window::Window;

/// Number of pieces along the edge, whose scatter gives the error of the comparison.
const STRIPS: usize = 16;

/// Least rise of an edge (10 to 90 %) that is judged, pixels. Beside a sharper one straight lines
/// between the bins miss the profile by more than filtered noise.
const WIDE_PX: f64 = 4.0;

/// Standard errors by which the noise on the edge has to exceed that beside it `MUCH` times.
/// Demosaicing changes it up to 1.4 times.
const SURE: f64 = 5.0;
const MUCH: f64 = 1.5;

/// Standard deviation of the noise on the edge, as a share of the step, below which a picture has
/// none: what is left of the profile is then interpolation.
const NO_NOISE: f64 = 3e-4;

/// Least overshoot that is named, as a share of the step.
const OVERSHOOT: f64 = 0.01;

/// Returns by how many times, as a variance, the noise on the edge exceeds that beside it; `None`
/// if it does not clearly. `rise_px` is the distance from 10 to 90 % of the step.
///
/// Noise of a sensor is called reduced in fewer than 1 of 10^5 photographs.
pub(crate) fn excess_on_edge(
    window: &Window,
    line: &EdgeLine,
    profile: &Profile,
    rise_px: f64,
) -> Option<f64> {
    let beside_px = rise_px.max(0.5 * profile.reach as f64 * BIN_PX);
    if rise_px < WIDE_PX || 1.2 * rise_px > profile.reach as f64 * BIN_PX {
        return None;
    }
    let (dark, bright) = profile.plateaus();
    let (sin, cos) = line.normal_rad.sin_cos();
    let is_steep = cos.abs() >= sin.abs();
    let centre = [window.width(), window.height()].map(|side| 0.5 * (side as f64 - 1.0));
    let ruler = line.ruler();
    let off = |column: usize, row: usize| {
        let (x, y) = (column as f64 - centre[0], row as f64 - centre[1]);
        let (s, t) = ruler.place(x, y);
        let value = f64::from(window.at(column, row));
        let level = profile.at(s).filter(|_| !value.is_nan())?;
        Some((s, t, level, value - level))
    };
    let half_px = centre[0] * sin.abs() + centre[1] * cos.abs();
    // Sums on the edge by strips: number, level, squares of differences.
    let mut on = [[0.0; 3]; STRIPS];
    // Number and squares beside it, on the dark and on the bright side.
    let mut beside = [[0.0; 2]; 2];
    let (right, below) = if is_steep { (0, 2) } else { (2, 0) };
    for row in 0..window.height().saturating_sub(below) {
        for column in 0..window.width().saturating_sub(right) {
            let Some((s, t, level, own)) = off(column, row) else {
                continue;
            };
            let is_on = s.abs() < 0.35 * rise_px;
            if !is_on && s.abs() < beside_px {
                continue;
            }
            let Some((_, _, _, next)) = off(column + right, row + below) else {
                continue;
            };
            let square = 0.5 * (own - next).powi(2);
            if is_on {
                let strip = 0.5 * (t / half_px + 1.0) * STRIPS as f64;
                let strip = &mut on[(strip.max(0.0) as usize).min(STRIPS - 1)];
                strip[0] += 1.0;
                strip[1] += ((level - dark) / (bright - dark)).clamp(0.0, 1.0);
                strip[2] += square;
            } else {
                let side = &mut beside[usize::from(s > 0.0)];
                side[0] += 1.0;
                side[1] += square;
            }
        }
    }
    let [low, high] = beside.map(|[n, squares]| squares / n);
    let filled = on.iter().filter(|strip| strip[0] > 0.0);
    let all = filled
        .clone()
        .fold([0.0; 3], |sum, strip| [0, 1, 2].map(|k| sum[k] + strip[k]));
    let noise = all[2] / all[0];
    if !(low.is_finite() && high.is_finite()) || noise.sqrt() < NO_NOISE * (bright - dark) {
        return None;
    }
    let expected = |[n, level, _]: &[f64; 3]| n * low + level * (high - low);
    let ratio = all[2] / expected(&all);
    let count = filled.clone().count() as f64;
    let scatter: f64 = filled
        .map(|strip| (strip[2] - ratio * expected(strip)).powi(2))
        .sum();
    let of_edge = scatter * count / (count - 1.0) / expected(&all).powi(2);
    // Beside a wide edge few pixels may be left. The square of a difference has twice the square of
    // its mean as variance, and those that share a pixel, two for each, correlate by a quarter.
    let part = |share: f64, level: f64, n: f64| 3.0 / n * (share * level / expected(&all)).powi(2);
    let of_sides = part(all[0] - all[1], low, beside[0][0]) + part(all[1], high, beside[1][0]);
    let error = (of_edge + ratio.powi(2) * of_sides).sqrt();
    (ratio - SURE * error > MUCH).then_some(ratio)
}

/// Returns by how much the light beside the edge overshoots the bright plateau and undershoots the
/// dark one, as shares of the step; `None` if neither does clearly.
pub(crate) fn overshoot(profile: &Profile, rise_px: f64) -> Option<[f64; 2]> {
    let far = profile.distance_px(profile.len() - 1);
    let (from_px, to_px) = (0.5 * rise_px, 2.0 * rise_px + 3.0);
    if to_px > 0.7 * far {
        return None;
    }
    let mean = |bins: std::ops::Range<usize>| {
        let n = bins.len() as f64;
        let level: f64 = profile.mean[bins.clone()].iter().sum();
        let variance: f64 = profile.variance[bins].iter().sum();
        [level / n, variance / (n * n)]
    };
    let bin = |px: f64| (px / BIN_PX).round() as usize;
    const WIDTH: usize = 4;
    let (dark, bright) = profile.plateaus();
    let step = bright - dark;
    let over = [-1.0, 1.0].map(|side| {
        // The bins of a range of distances on this side.
        let range = |from: usize, to: usize| {
            if side > 0.0 {
                profile.reach + from..profile.reach + to
            } else {
                profile.reach + 1 - to..profile.reach + 1 - from
            }
        };
        let plateau = mean(range(bin(to_px), profile.reach + 1));
        let beside = (bin(from_px)..bin(to_px) - WIDTH).map(|from| {
            let own = mean(range(from, from + WIDTH));
            let over = side * (own[0] - plateau[0]);
            let sure = SURE * (own[1] + plateau[1]).sqrt();
            if over > sure { over / step } else { 0.0 }
        });
        beside.fold(0.0, f64::max)
    });
    (over[0].max(over[1]) > OVERSHOOT).then_some(over)
}
