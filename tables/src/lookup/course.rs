//! The lines on which the edges of a path's polygon lie, from direction to direction, and the
//! polygon that they leave between the directions.

use std::collections::HashSet;

use crate::lookup::shape::{Line, NearDirection, PathShape, SHORT, distance, dot};
use crate::table::polygon;

/// Greatest distance of the unit normals of two lines that may be one line that turned.
const SAME_SLOPE: f64 = 0.3;

/// Greatest move of a line for each unit of tau, edge lengths.
///
/// Light in a cube passes its height of 0.6 down and up, twice.
pub(crate) const FASTEST: f64 = 4.0;

/// Picks pairs from `costs`, the cheapest first, with each row and each column at most once.
pub(crate) fn assigned(mut costs: Vec<(f64, usize, usize)>) -> Vec<(usize, usize)> {
    costs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut rows, mut columns) = (HashSet::new(), HashSet::new());
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    for (_, row, column) in costs {
        if !rows.contains(&row) && columns.insert(column) {
            rows.insert(row);
            pairs.push((row, column));
        }
    }
    pairs
}

/// Line as the directions that have it show it: tau and the line there.
pub(crate) type LineTrack = Vec<([f64; 2], Line)>;

/// Finds the lines of a family.
pub(crate) fn lines(members: &[(&NearDirection, &PathShape)]) -> Vec<LineTrack> {
    let mut courses: Vec<LineTrack> = Vec::new();
    // For each line, the members that have it as an edge.
    let mut holders: Vec<Vec<usize>> = Vec::new();
    for (member, (node, shape)) in members.iter().enumerate() {
        let mut costs = Vec::new();
        for (which, course) in courses.iter().enumerate() {
            let near = course
                .iter()
                .min_by(|a, b| distance(a.0, node.tau).total_cmp(&distance(b.0, node.tau)));
            let known = near.map_or(course[0].1, |near| near.1);
            for (index, line) in shape.lines.iter().enumerate() {
                let turn = distance(line.normal, known.normal);
                if turn < SAME_SLOPE {
                    costs.push((turn + (line.offset - known.offset).abs(), which, index));
                }
            }
        }
        let pairs = assigned(costs);
        for (index, &line) in shape.lines.iter().enumerate() {
            let known = pairs.iter().find(|(_, taken)| *taken == index);
            let which = known.map_or(courses.len(), |&(which, _)| which);
            if which == courses.len() {
                courses.push(Vec::new());
                holders.push(Vec::new());
            }
            courses[which].push((node.tau, line));
            holders[which].push(member);
        }
    }
    for (course, holders) in courses.iter_mut().zip(&holders) {
        keep_clear(course, members, holders);
    }
    courses
}

/// Keeps a line clear of the polygons of the members that lack it.
///
/// In such a member the line lies beyond the polygon. If the other members' lines would lead it
/// through the polygon, a line is added that touches the polygon. It moves the line elsewhere, so
/// this goes on until the line is clear of all.
fn keep_clear(course: &mut LineTrack, members: &[(&NearDirection, &PathShape)], holders: &[usize]) {
    let mut without: Vec<usize> = (0..members.len())
        .filter(|member| !holders.contains(member))
        .collect();
    loop {
        let mut touching = LineTrack::new();
        without.retain(|&member| {
            let (node, shape) = members[member];
            let Line { normal, offset } = line_at(course, node.tau);
            let reach = shape.reach(normal);
            let clear = offset >= reach;
            if !clear {
                let line = Line {
                    normal,
                    offset: reach,
                };
                touching.push((node.tau, line));
            }
            clear
        });
        if touching.is_empty() {
            return;
        }
        course.extend(touching);
    }
}

/// Interpolates a line at `tau`; its normal need not be of unit length.
fn line_at(course: &LineTrack, tau: [f64; 2]) -> Line {
    let places: Vec<[f64; 2]> = course.iter().map(|(place, _)| *place).collect();
    let (mut normal, mut offset) = ([0.0; 2], 0.0);
    for (weight, (_, line)) in weights(&places, tau).into_iter().zip(course) {
        normal = [0, 1].map(|k| normal[k] + weight * line.normal[k]);
        offset += weight * line.offset;
    }
    Line { normal, offset }
}

/// Returns the polygon that the lines leave at `tau`, empty if they leave nothing.
///
/// Nothing is left where the polygons of the members cannot have moved to. Lines that hardly turn
/// from each other can meet far away, after the path between them has ended.
pub(crate) fn outline(
    courses: &[LineTrack],
    members: &[(&NearDirection, &PathShape)],
    tau: [f64; 2],
) -> Vec<[f64; 2]> {
    let moved = members
        .iter()
        .map(|(node, _)| FASTEST * distance(node.tau, tau));
    let margin = moved.fold(f64::INFINITY, f64::min) + SHORT;
    let corners = || members.iter().flat_map(|(_, shape)| &shape.corners);
    let side = |axis: usize| {
        let along = || corners().map(|corner| corner[axis]);
        let low = along().fold(f64::INFINITY, f64::min) - margin;
        (low, along().fold(f64::NEG_INFINITY, f64::max) + margin)
    };
    let ((left, right), (low, high)) = (side(0), side(1));
    let mut polygon = vec![[left, low], [right, low], [right, high], [left, high]];
    for course in courses {
        polygon = clipped(&polygon, line_at(course, tau));
    }
    polygon
}

/// Returns the part of a convex polygon in a half-plane.
pub(crate) fn clipped(polygon: &[[f64; 2]], line: Line) -> Vec<[f64; 2]> {
    let beyond = |p: [f64; 2]| dot(line.normal, p) - line.offset;
    let on = |p: [f64; 2], q: [f64; 2], part: f64| [0, 1].map(|k| p[k] + part * (q[k] - p[k]));
    polygon::clip(polygon, beyond, on)
}

/// Returns the shares of values at `places` in the interpolated value at `tau`.
///
/// They belong to the best affine function by the weights 1 / distance^4. If the places lie on one
/// line, the function does not change across it.
pub(crate) fn weights(places: &[[f64; 2]], tau: [f64; 2]) -> Vec<f64> {
    let nearest = places
        .iter()
        .map(|&place| distance(place, tau))
        .fold(f64::INFINITY, f64::min);
    if nearest == 0.0 {
        let here: Vec<f64> = places
            .iter()
            .map(|&place| f64::from(u8::from(place == tau)))
            .collect();
        let count: f64 = here.iter().sum();
        return here.iter().map(|one| one / count).collect();
    }
    let terms: Vec<(f64, [f64; 3])> = places
        .iter()
        .map(|place| {
            let [x, y] = [0, 1].map(|k| (place[k] - tau[k]) / nearest);
            ((x * x + y * y).powi(-2), [1.0, x, y])
        })
        .collect();
    let mut normal = [[0.0; 3]; 3];
    for (weight, basis) in &terms {
        for (row, a) in normal.iter_mut().zip(basis) {
            for (sum, b) in row.iter_mut().zip(basis) {
                *sum += weight * a * b;
            }
        }
    }
    // The ridge makes slopes 0 that nothing determines. It is small, because close to a direction
    // the weights of the others are small, and they alone determine the slopes.
    let ridge = 1e-12 * normal[0][0];
    normal[1][1] += ridge;
    normal[2][2] += ridge;
    let [[a, b, c], [_, d, e], [_, _, f]] = normal;
    // First column of the inverse, by cofactors.
    let column = [d * f - e * e, c * e - b * f, b * e - c * d];
    let determinant = a * column[0] + b * column[1] + c * column[2];
    let value = |(weight, basis): &(f64, [f64; 3])| {
        let sum: f64 = basis.iter().zip(&column).map(|(x, y)| x * y).sum();
        weight * sum / determinant
    };
    terms.iter().map(value).collect()
}
