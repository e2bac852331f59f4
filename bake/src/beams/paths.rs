//! Joins pieces of light that share a map and a weight into one polygon.
//!
//! The order in which light meets the faces of one cube does not change its ray shift: the six
//! facet sequences of an ideal cube are one polygon with one map. If there are losses, the orders
//! change the polarisation in different ways and stay apart. They do so too where symmetry makes
//! their powers equal, as along the azimuth of a mirror plane: a path goes on from one direction to
//! the next, and so a table can be interpolated.
//!
//! In a lattice the pieces of one cube may have been lit through different copies. Each piece is
//! moved to the period that holds the fixed point of its map, which is the centre of the cube.
//! There the pieces meet.

use glam::DVec2;
use tables::Path;

use crate::beams::beam::LitPiece;
use crate::beams::view::View;
use crate::geometry::{Polygon, polygon};

/// Largest difference of two maps that count as the same one, relative to the size of the offset.
/// The rounding of a few reflections is 1e-15.
const SAME_MAP: f64 = 1e-13;

/// Largest difference of two weights, and of fields of unit power, that count as the same one. The
/// rounding of a few reflections is 1e-15.
const SAME_WEIGHT: f64 = 1e-13;

/// Largest angle between two deviations that count as the same one, rad. Rounding is far smaller.
const SAME_DIRECTION: f64 = 1e-12;

/// Joins `pieces` and returns them as the paths of a table.
pub(crate) fn merge(mut pieces: Vec<LitPiece>, view: &View) -> Vec<Path> {
    if let Some(lattice) = view.lattice {
        pieces
            .iter_mut()
            .for_each(|piece| bring_home(piece, lattice));
    }
    let mut paths: Vec<LitPiece> = Vec::new();
    let mut rest = pieces;
    while !rest.is_empty() {
        let first = rest[0].clone();
        let (group, others): (Vec<LitPiece>, Vec<LitPiece>) =
            rest.into_iter().partition(|piece| same_map(piece, &first));
        rest = others;
        let slack = 4.0 * view.least_area;
        let polygons = unite(
            group.into_iter().map(|piece| piece.polygon).collect(),
            slack,
        );
        paths.extend(polygons.into_iter().map(|polygon| LitPiece {
            polygon,
            ..first.clone()
        }));
    }
    paths.into_iter().map(path).collect()
}

/// Moves a piece by the lattice vector that brings its fixed point into the base period.
///
/// A piece with a nearly singular map has no fixed point to speak of and stays where it is.
fn bring_home(piece: &mut LitPiece, [a, b]: [DVec2; 2]) {
    if piece.matrix.determinant().abs() < 1e-3 {
        return;
    }
    let fixed = -(piece.matrix.inverse() * piece.offset);
    // Without the 1e-9, pieces whose fixed points differ by rounding could land in different
    // periods.
    let i = (fixed.perp_dot(b) / a.perp_dot(b) + 1e-9).floor();
    let j = (a.perp_dot(fixed) / a.perp_dot(b) + 1e-9).floor();
    if i != 0.0 || j != 0.0 {
        let home = -(i * a + j * b);
        piece.polygon.iter_mut().for_each(|p| *p += home);
        piece.offset -= piece.matrix * home;
    }
}

fn same_map(a: &LitPiece, b: &LitPiece) -> bool {
    let alike = match (&a.jones, &b.jones) {
        (Some(a), Some(b)) => {
            let pairs = a.as_flattened().iter().zip(b.as_flattened());
            let apart = pairs.map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
            apart.sum::<f64>() <= SAME_WEIGHT
        }
        _ => true,
    };
    let slack = SAME_MAP * (1.0 + a.offset.length());
    let linear = a.matrix - b.matrix;
    a.passes == b.passes
        && alike
        && (a.weight - b.weight).abs() <= SAME_WEIGHT
        && (a.deviation - b.deviation).length() <= SAME_DIRECTION
        && (a.offset - b.offset).length() <= slack
        && linear.x_axis.length() + linear.y_axis.length()
            <= SAME_MAP * (1.0 + a.matrix.x_axis.length())
}

/// Unites convex polygons that do not overlap, as far as their unions are convex.
///
/// A union is convex if the hull has no more area than its parts, within `slack`.
fn unite(mut polygons: Vec<Polygon>, slack: f64) -> Vec<Polygon> {
    let union = |parts: &[&Polygon]| {
        let points: Vec<DVec2> = parts.iter().flat_map(|p| p.iter().copied()).collect();
        let hull = polygon::hull(&points, 4.0 * f64::EPSILON);
        let sum: f64 = parts.iter().map(|p| polygon::area(p)).sum();
        ((polygon::area(&hull) - sum).abs() <= slack).then_some(hull)
    };
    if let Some(all) = union(&polygons.iter().collect::<Vec<_>>()) {
        return vec![all];
    }
    let mut i = 0;
    while i < polygons.len() {
        let found =
            (i + 1..polygons.len()).find_map(|j| Some((j, union(&[&polygons[i], &polygons[j]])?)));
        match found {
            Some((j, joined)) => {
                polygons[i] = joined;
                polygons.remove(j);
                // An earlier polygon that fitted nothing before may fit the union.
                i = 0;
            }
            None => i += 1,
        }
    }
    polygons
}

fn path(piece: LitPiece) -> Path {
    let [u, v] = piece.matrix.to_cols_array_2d();
    Path {
        polygon: piece.polygon.iter().map(|p| p.to_array()).collect(),
        matrix: [[u[0], v[0]], [u[1], v[1]]],
        offset: piece.offset.to_array(),
        weight: piece.weight,
        deviation: piece.deviation.to_array(),
        passes: piece.passes,
        jones: piece.jones,
        cube: piece.cube,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_triangles_of_a_fan_unite_and_separate_ones_stay() {
        let corner = |i: usize| DVec2::from_angle(i as f64 * std::f64::consts::FRAC_PI_3);
        let fan = (0..6).map(|i| vec![DVec2::ZERO, corner(i), corner(i + 1)]);
        let far = vec![
            DVec2::new(5.0, 0.0),
            DVec2::new(6.0, 0.0),
            DVec2::new(5.0, 1.0),
        ];
        let united = unite(fan.chain([far.clone()]).collect(), 1e-14);
        assert_eq!(united.len(), 2);
        assert_eq!(united[0].len(), 6);
        assert!((polygon::area(&united[0]) - 1.5 * 3_f64.sqrt()).abs() < 1e-14);
        assert_eq!(united[1], far);
    }
}
