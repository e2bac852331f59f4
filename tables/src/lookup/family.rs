//! What the interpolation between directions knows of each path, for those who bound its error.

use crate::lookup::between::{absent, families, shapes};
use crate::lookup::course::{FASTEST, LineTrack, clipped, lines, weights};
use crate::lookup::shape::{Line, NearDirection, PathShape, SHORT, deviation, distance};
use crate::table::polygon::area;

/// Path of the sheet as the directions around a gap show it: all that the interpolation between
/// them knows, whatever direction of the gap is asked for.
///
/// Everything is in the frame of azimuth 0, relative to the fixed point of the path's map, in edge
/// lengths. A value at tau is the mean of those of the directions, weighted as the head of
/// `lookup/between.rs` says.
#[derive(Debug, Clone, PartialEq)]
pub struct Family {
    /// Lines that bound the polygon: for each, the directions that show it, as tau and (normal,
    /// offset). The polygon is where normal . p is at most the offset.
    pub lines: Vec<Vec<([f64; 2], [f64; 3])>>,
    /// Directions that have the path: tau, and row-major matrix, tangents astray, weight.
    ///
    /// The tangents are the part along the sheet of (M + 1) (tau, -1), where M is the linear map of
    /// the path inside.
    pub members: Vec<([f64; 2], [f64; 7])>,
    /// Least and greatest coordinates of the corners in all these directions.
    pub bounds: [[f64; 2]; 2],
    /// Shares of the directions that lack the path by a jump, as (greater incidence, greater
    /// azimuth) of the corner of the gap.
    pub jumps: Vec<[f64; 2]>,
    /// Number of times that the front face has sent the light of the path back inside.
    pub passes: u32,
}

impl Family {
    /// Greatest move of a corner for each unit of tau, edge lengths.
    ///
    /// At tau the polygon lies within [`Family::bounds`], widened by this times the distance to the
    /// nearest direction that has the path.
    pub const FASTEST: f64 = FASTEST;

    /// Evaluates the lines, and the numbers of [`Family::members`], at a direction tau.
    ///
    /// Normals are not of unit length.
    pub fn at(&self, tau: [f64; 2]) -> (Vec<[f64; 3]>, [f64; 7]) {
        let lines = self.lines.iter().map(|course| mean(course, tau));
        (lines.collect(), mean(&self.members, tau))
    }

    /// Returns the light of the path at a direction tau: the area of its polygon times its weight.
    ///
    /// `share` is that of a corner of the gap in a bilinear mixture, with corners as
    /// [`Family::jumps`] has them.
    pub(crate) fn light(&self, tau: [f64; 2], share: impl Fn([f64; 2]) -> f64) -> f64 {
        let moved = self.members.iter().map(|(place, _)| distance(*place, tau));
        let margin = FASTEST * moved.fold(f64::INFINITY, f64::min) + SHORT;
        let [[left, low], [right, high]] = self.bounds;
        let ([left, low], [right, high]) = (
            [left - margin, low - margin],
            [right + margin, high + margin],
        );
        let mut outline = vec![[left, low], [right, low], [right, high], [left, high]];
        let (lines, numbers) = self.at(tau);
        for [x, y, offset] in lines {
            let normal = [x, y];
            outline = clipped(&outline, Line { normal, offset });
        }
        // A direction lacks the path by a jump: its share of the gap has none of the light.
        let absent: f64 = self.jumps.iter().map(|&corner| share(corner)).sum();
        area(&outline) * numbers[6].clamp(0.0, 1.0) * (1.0 - absent).max(0.0)
    }

    /// Converts tangents astray, in the incidence frame, to a deviation as [`crate::Path`] has it.
    ///
    /// `index` is the refractive index of the sheet.
    pub fn deviation(astray: [f64; 2], tau: [f64; 2], index: f64) -> [f64; 2] {
        deviation(astray, tau, index)
    }
}

/// Returns the mean at `tau` of the values of some directions.
///
/// It is taken relative to the first, so that a value that all share comes out unchanged.
fn mean<const N: usize>(values: &[([f64; 2], [f64; N])], tau: [f64; 2]) -> [f64; N] {
    let places: Vec<[f64; 2]> = values.iter().map(|(place, _)| *place).collect();
    let first = values[0].1;
    let mut mean = first;
    for (weight, (_, value)) in weights(&places, tau).into_iter().zip(values) {
        for k in 0..N {
            mean[k] += weight * (value[k] - first[k]);
        }
    }
    mean
}

/// Returns the families between `nodes`, or `None` if they cannot be interpolated.
///
/// They are those of [`crate::lookup::between::paths`]: neither depends on the direction that is asked for, but
/// only on which nodes have a share.
pub(crate) fn known(nodes: &[NearDirection], index: f64) -> Option<Vec<Family>> {
    let seen = shapes(nodes, index)?;
    let of = |family: Vec<(usize, usize)>| {
        let members: Vec<(&NearDirection, &PathShape)> = family
            .iter()
            .map(|&(node, path)| (&nodes[node], &seen[node][path]))
            .collect();
        let lines: Vec<LineTrack> = lines(&members);
        let jumps = absent(nodes, &family, &lines, &members);
        let corners = || members.iter().flat_map(|(_, shape)| &shape.corners);
        let end = |axis: usize, start: f64, pick: fn(f64, f64) -> f64| {
            corners().map(|corner| corner[axis]).fold(start, pick)
        };
        Family {
            passes: members[0].1.passes,
            jumps: jumps.iter().map(|node| node.corner).collect(),
            bounds: [
                [0, 1].map(|axis| end(axis, f64::INFINITY, f64::min)),
                [0, 1].map(|axis| end(axis, f64::NEG_INFINITY, f64::max)),
            ],
            lines: lines
                .iter()
                .map(|course| {
                    let line = |(tau, line): &([f64; 2], Line)| {
                        (*tau, [line.normal[0], line.normal[1], line.offset])
                    };
                    course.iter().map(line).collect()
                })
                .collect(),
            members: members
                .iter()
                .map(|(node, shape)| {
                    let ([[a, b], [c, d]], [x, y]) = (shape.matrix, shape.astray);
                    (node.tau, [a, b, c, d, x, y, shape.weight])
                })
                .collect(),
        }
    };
    Some(families(nodes, &seen).into_iter().map(of).collect())
}
