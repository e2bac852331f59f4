//! How much light the difference of two maps moves to another bin.

use glam::DVec2;

use crate::plan::default;
use crate::proof::means::Enclosed;
use crate::proof::moving::{Patch, most};
use crate::proof::returned::Returned;

/// Points that a true and an interpolated path share, and where their fixed points are.
pub(crate) struct Shared<'a> {
    /// Holds all of the points.
    pub points: &'a [DVec2],
    /// Bound of their area in each direction.
    pub area: f64,
    /// Fixed point of the interpolated map, affine in (s, t), and its error.
    pub from: ([DVec2; 3], f64),
    /// Way from the fixed point of the true map to it, and the error of that.
    pub apart: ([DVec2; 3], f64),
}

/// Returns a bound of the area of the points whose two shifts lie in different bins.
///
/// Let M (x - q) be the true shift, N (x - q') the interpolated one. They differ by
/// d = (M - N) (x - q') + M (q' - q). Each coordinate of d is enclosed, along the incidence and
/// across it, for bins have these axes. If it lies between -a and b, a and b >= 0, it crosses a
/// border of bins only if the true shift is between a before the border and b behind it. The points
/// of such a shift form strips across the row r of M. In a direction the points form a convex
/// polygon of area A, whose chord across r has one maximum, c. So chords at distances of a bin, w,
/// sum to at most the integral over the shift by w, A |r| / w, and c. The integral over a strip is
/// that over a + b of such sums: the strips have at most the area (a + b) (A / w + c / |r|).
pub(crate) fn crossing(
    truth: &Returned,
    guess: &Enclosed<7>,
    shared: &Shared<'_>,
    patch: &Patch,
) -> f64 {
    let width = 2.0 * default::RANGE / default::BINS as f64;
    let ends = apart(truth, guess, shared, patch);
    let mut sum = 0.0;
    for (axis, [low, high]) in [patch.axis, patch.axis.perp()].into_iter().zip(ends) {
        let moved = high.max(0.0) + (-low).max(0.0);
        let Some((steep, longest)) = chord(truth, shared.points, axis, patch.turn) else {
            return shared.area;
        };
        sum += moved * (shared.area / width + longest / steep);
    }
    // Infinite and undefined bounds are none.
    if sum < shared.area { sum } else { shared.area }
}

/// Encloses the coordinates of the difference of the shifts.
fn apart(
    truth: &Returned,
    guess: &Enclosed<7>,
    shared: &Shared<'_>,
    patch: &Patch,
) -> [[f64; 2]; 2] {
    let ((from, error), (gap, gap_error)) = (shared.from, shared.apart);
    let spread = |place: [DVec2; 3], error: f64| place[1].abs() + place[2].abs() + error;
    let (loose, gap_loose) = (spread(from, error), spread(gap, gap_error));
    let far = shared.points.iter().map(|&x| (x - from[0]).abs());
    let far = far.fold(DVec2::ZERO, DVec2::max) + loose;
    // Rows: difference of the maps and true map in the middle, and their radii.
    let row = |row: usize| {
        let of = |k: usize| {
            let ((a, e), (b, f)) = (truth.map[2 * row + k], guess[2 * row + k]);
            let change = most([0.0, a[1] - b[1], a[2] - b[2]]) + e + f;
            [a[0] - b[0], change, a[0], most([0.0, a[1], a[2]]) + e]
        };
        let (x, y) = (of(0), of(1));
        [0, 1, 2, 3].map(|k| DVec2::new(x[k], y[k]))
    };
    let rows = [row(0), row(1)];
    let radius = rows.map(|[off, change, map, map_change]| {
        change.dot(far)
            + off.abs().dot(loose)
            + map.abs().dot(gap_loose)
            + map_change.dot(gap[0].abs() + gap_loose)
    });
    let radius = radius[0].hypot(radius[1]);
    let middle = |x: DVec2| {
        let at = rows.map(|[off, _, map, _]| off.dot(x - from[0]) + map.dot(gap[0]));
        DVec2::from_array(at)
    };
    let longest = shared.points.iter().map(|&x| middle(x).length());
    let longest = longest.fold(0.0, f64::max);
    // The axes of the bins turn with the azimuth.
    let loose = radius + patch.turn * (longest + radius);
    [patch.axis, patch.axis.perp()].map(|axis| {
        let along = || shared.points.iter().map(|&x| middle(x).dot(axis));
        let low = along().fold(f64::INFINITY, f64::min);
        let high = along().fold(f64::NEG_INFINITY, f64::max);
        [low - loose, high + loose]
    })
}

/// Returns the least length of the row of the true map along `axis`, and a bound of the chords of
/// `points` across it, or `None` if the row turns too much.
///
/// The row is off from that in the middle by at most the change of the map and the turn of the
/// axis. A chord across it, seen along the chords across the one in the middle, is shorter by the
/// cosine between the two at most.
fn chord(truth: &Returned, points: &[DVec2], axis: DVec2, turn: f64) -> Option<(f64, f64)> {
    let value = |k: usize| truth.map[k].0[0];
    let change = |k: usize| most([0.0, truth.map[k].0[1], truth.map[k].0[2]]) + truth.map[k].1;
    let size = |of: &dyn Fn(usize) -> f64| (0..4).map(|k| of(k) * of(k)).sum::<f64>().sqrt();
    let row = axis.x * DVec2::new(value(0), value(1)) + axis.y * DVec2::new(value(2), value(3));
    let changes = size(&change);
    let loose = changes + turn * (size(&value) + changes);
    let part = loose / row.length();
    if part.is_nan() || part > 0.5 {
        return None;
    }
    let across = row.perp() / row.length();
    let along = || points.iter().map(|x| x.dot(across));
    let extent = along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min);
    let longest = extent.max(0.0) / (1.0 - part * part).sqrt();
    Some((row.length() - loose, longest))
}
