//! An interpolated path, enclosed over a patch of directions.

use glam::DVec2;
use tables::Family;

use crate::geometry::Polygon;
use crate::proof::means::{Enclosed, enclose, shared};
use crate::proof::moving::{Affine, Moving, Patch, ever, most};
use crate::proof::returned::Returned;

/// Greatest sum of the unit normals of two lines that are taken for two sides of one.
const FACING: f64 = 0.05;

/// Interpolated path, relative to its fixed point.
pub(crate) struct Guess<'a> {
    family: &'a Family,
    pub lines: Vec<Moving>,
    /// Greatest error of the normal of each line.
    pub loose: Vec<f64>,
    /// Distance from the fixed point within which the errors hold.
    reach: f64,
    /// Sides of the box that it is cut to; they may lie too far inside.
    pub sides: Vec<Moving>,
    /// Holds all its points.
    pub ever: Polygon,
    /// Map, tangents astray and weight, as in [`Family::members`].
    pub values: Enclosed<7>,
    /// Number of times that the front has sent its light back.
    pub passes: usize,
}

impl<'a> Guess<'a> {
    /// Encloses `family` over `patch`.
    pub(crate) fn new(family: &'a Family, patch: &Patch) -> Guess<'a> {
        let places = || {
            family
                .members
                .iter()
                .map(|(tau, _)| DVec2::from_array(*tau))
        };
        let least = |pick: fn((f64, f64)) -> f64| {
            let moved = places().map(|tau| pick(patch.distances(tau)));
            Family::FASTEST * moved.fold(f64::INFINITY, f64::min)
        };
        let [low, high] = family.bounds.map(DVec2::from_array);
        let (inner, outer) = (least(|(_, near)| near), least(|(far, _)| far) + 1e-6);
        let (from, to) = (low - outer, high + outer);
        let reach = from.abs().max(to.abs()).length();
        let lines = family.lines.iter().map(|line| mean(line, patch, reach));
        let (lines, loose): (Vec<Moving>, Vec<f64>) = lines.unzip();
        let side = |normal: DVec2, offset: f64| Moving {
            offset: [-offset - inner, 0.0, 0.0],
            normal: [normal, DVec2::ZERO, DVec2::ZERO],
            error: 0.0,
        };
        let start = [from, DVec2::new(to.x, from.y), to, DVec2::new(from.x, to.y)];
        Guess {
            family,
            // The second cut is tighter: changes are least in a small polygon.
            ever: ever(&ever(&start, &lines), &lines),
            lines,
            loose,
            reach,
            sides: vec![
                side(DVec2::X, high.x),
                side(DVec2::Y, high.y),
                side(DVec2::NEG_X, -low.x),
                side(DVec2::NEG_Y, -low.y),
            ],
            values: enclose(&family.members, patch),
            passes: family.passes as usize,
        }
    }

    /// Returns the lines of this path and of `other` that are one line with two sides: their
    /// numbers, and the sum of their functions, each taken from its own fixed point.
    ///
    /// They are so if the same directions show both. Then both are means with the same weights, and
    /// so is their sum. It hardly changes, however far the lines turn.
    pub(crate) fn facing(&self, other: &Guess<'_>, patch: &Patch) -> Vec<(usize, usize, Moving)> {
        let mut found = Vec::new();
        // At normal incidence several directions are one tau.
        let theirs: Vec<_> = other.family.lines.iter().map(|line| shared(line)).collect();
        for (ours, line) in self.family.lines.iter().enumerate() {
            let line = shared(line);
            for (theirs, across) in theirs.iter().enumerate() {
                let sum = |(tau, own): &([f64; 2], [f64; 3])| {
                    let (_, facing) = across.iter().find(|(at, _)| at == tau)?;
                    let sum = [0, 1, 2].map(|k| own[k] + facing[k]);
                    (sum[0].hypot(sum[1]) < FACING).then_some((*tau, sum))
                };
                if line.len() == across.len()
                    && let Some(sums) = line.iter().map(sum).collect::<Option<Vec<_>>>()
                {
                    found.push((ours, theirs, mean(&sums, patch, self.reach).0));
                }
            }
        }
        found
    }

    /// Returns whether the patch is small enough for an enclosure.
    pub(crate) fn is_finite(&self) -> bool {
        let lines = self.lines.iter().map(|line| line.error);
        lines
            .chain(self.values.map(|(_, error)| error))
            .all(f64::is_finite)
    }

    /// Returns a bound of the difference of the tangents astray.
    pub(crate) fn turned(&self, returned: &Returned) -> f64 {
        let off = |k: usize| {
            let ((a, e), (b, f)) = (returned.map[k], self.values[k]);
            most([a[0] - b[0], a[1] - b[1], a[2] - b[2]]) + e + f
        };
        off(4).hypot(off(5))
    }

    /// Returns a bound of what the weight is off from `weight`, in the part of the gap given.
    pub(crate) fn lost(
        &self,
        (weight, loose): (Affine, f64),
        gap: [[f64; 2]; 2],
        part: [[f64; 2]; 2],
    ) -> f64 {
        let (weights, error) = self.values[6];
        let off = [0, 1, 2].map(|k| weights[k] - weight[k]);
        let jumped = self.jumped(gap, part)[1] * (most(weights) + error);
        jumped + most(off) + error + loose
    }

    /// Returns a bound of the weight in the part of the gap given.
    pub(crate) fn weight(&self, gap: [[f64; 2]; 2], part: [[f64; 2]; 2]) -> f64 {
        let (weights, error) = self.values[6];
        (most(weights) + error).min(1.0) * (1.0 - self.jumped(gap, part)[0]).max(0.0)
    }

    /// Returns the least and the greatest share of corners that lack the path by a jump.
    fn jumped(&self, gap: [[f64; 2]; 2], part: [[f64; 2]; 2]) -> [f64; 2] {
        let along = |corner: &[f64; 2], axis: usize| {
            let [from, to] = gap[axis];
            let share = |x: f64| {
                let at = (x - from) / (to - from);
                if corner[axis] > 0.0 { at } else { 1.0 - at }
            };
            let [a, b] = part[axis].map(share);
            if to > from {
                [a.min(b), a.max(b)]
            } else {
                [1.0; 2]
            }
        };
        let shares = |corner: &[f64; 2]| {
            let (a, b) = (along(corner, 0), along(corner, 1));
            [a[0] * b[0], a[1] * b[1]]
        };
        let all = self.family.jumps.iter().map(shares);
        all.fold([0.0; 2], |sum, share| {
            [sum[0] + share[0], sum[1] + share[1]]
        })
    }
}

/// Encloses an interpolated line; its error is that at points within `reach` of the fixed point.
/// The second number is the error of its normal.
fn mean(line: &[([f64; 2], [f64; 3])], patch: &Patch, reach: f64) -> (Moving, f64) {
    let [(x, ex), (y, ey), (offset, error)] = enclose(line, patch);
    let loose = ex.hypot(ey);
    let line = Moving {
        offset: offset.map(|part| -part),
        normal: [0, 1, 2].map(|k| DVec2::new(x[k], y[k])),
        error: loose * reach + error,
    };
    (line, loose)
}
