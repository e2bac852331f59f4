//! Interpolation of the polygons of an exact table between its directions.
//!
//! The lines on which the edges of a polygon lie are interpolated. Let tau = tan(incidence inside)
//! (cos azimuth, sin azimuth). The shadow of a planar facet's corner on the entrance plane is
//! linear in tau, however often the facet is unfolded. The line through two such shadows is linear
//! in tau too, up to a factor; for an ideal cube it keeps its slope. The corners of a polygon obey
//! no such law: they come and go as lines pass each other. If a direction lacks an edge, because
//! other lines lie before it, the line comes from the directions that have it. A path that ends
//! between two directions ends where its lines leave no area.
//!
//! Lines, maps and weights are interpolated by moving least squares. The result is the value of the
//! affine function of tau that fits the directions around best, with the inverse fourth power of
//! the distance as weight. It equals the table in the table's own directions, and the truth
//! wherever the truth is affine. Elsewhere the error is of second order in the spacing.
//!
//! Polygons are taken relative to the fixed point of their map, so that the map has no offset.
//! Cubes that lie elsewhere, as the images of symmetry and of a lattice do, then become the same
//! cube. The result is placed where the steepest direction has it.

use crate::lookup::course::{FASTEST, LineTrack, assigned, lines, outline, weights};
use crate::lookup::shape::{
    NearDirection, PathShape, SHORT, deviation, distance, dot, mean_field, scaled, turned,
    turned_cube, turned_map,
};
use crate::table::exact::Path;
use crate::table::polygon::area;

/// Smallest area that is more than rounding, square edge lengths.
const NO_AREA: f64 = 1e-12;

/// Greatest change of the numbers of [`PathShape::astray`] for each unit of tau, as a part of the greatest of
/// these numbers.
///
/// They are w x (tau, -1) for light that is turned by the small rotation w. They change by |w| at
/// most, and they are |w| where w lies across the light. The turn about the normal, w_z, is
/// compared beside them; the map shows it up to a part of |tau|.
const TURN: f64 = 1.5;

/// Rotation of light, rad, below which paths are not told apart by it: far above rounding, far
/// below any error of a facet.
const LEAST_ASTRAY: f64 = 1e-9;

/// Part of a path's area from which on its absence in a direction is a jump.
///
/// The lines of the path are continued to the direction that lacks it. If they leave more than this
/// part there, the path ends by a jump, as at the limit of total reflection.
const JUMP: f64 = 0.25;

/// Returns the shapes of the paths of each node, or `None` if one cannot be interpolated.
pub(crate) fn shapes(nodes: &[NearDirection], index: f64) -> Option<Vec<Vec<PathShape>>> {
    let of = |node: &NearDirection| {
        let shapes = node
            .paths
            .iter()
            .map(|path| PathShape::new(path, node, index));
        shapes.collect()
    };
    nodes.iter().map(of).collect()
}

/// Returns the nodes with a share that lack a family by a jump.
pub(crate) fn absent<'a>(
    nodes: &'a [NearDirection],
    family: &[(usize, usize)],
    lines: &[LineTrack],
    members: &[(&NearDirection, &PathShape)],
) -> Vec<&'a NearDirection> {
    let lacking = nodes.iter().enumerate().filter(|&(index, node)| {
        let lacks = node.share > 0.0 && family.iter().all(|&(member, _)| member != index);
        let there = || area(&outline(lines, members, node.tau));
        lacks && there() > JUMP * members[0].1.area
    });
    lacking.map(|(_, node)| node).collect()
}

/// Returns the paths at `tau` in the frame of `azimuth_rad`, interpolated between `nodes`.
///
/// `index` is the refractive index of the sheet. Returns `None` if the paths of the nodes cannot be
/// interpolated: a polygon is not convex, or a map cannot be inverted.
pub(crate) fn paths(
    nodes: &[NearDirection],
    tau: [f64; 2],
    azimuth_rad: f64,
    index: f64,
) -> Option<Vec<Path>> {
    let seen = shapes(nodes, index)?;
    let mut paths = Vec::new();
    let families = families(nodes, &seen);
    let places = places(&families, &seen);
    for (family, place) in families.into_iter().zip(places) {
        let members: Vec<(&NearDirection, &PathShape)> = family
            .iter()
            .map(|&(node, path)| (&nodes[node], &seen[node][path]))
            .collect();
        let lines = lines(&members);
        let polygon = outline(&lines, &members, tau);
        if area(&polygon) <= NO_AREA {
            continue;
        }
        let absent = absent(nodes, &family, &lines, &members);
        let present = 1.0 - absent.iter().map(|node| node.share).sum::<f64>();
        let taus: Vec<[f64; 2]> = members.iter().map(|(node, _)| node.tau).collect();
        let weights = weights(&taus, tau);
        // The mean is taken relative to the first member: a value that all members share comes out
        // unchanged, to the last digit.
        let seed = members[0].1;
        let mean = |value: &dyn Fn(&PathShape) -> f64| -> f64 {
            let beyond = members.iter().map(|(_, shape)| value(shape) - value(seed));
            let beyond = beyond.zip(&weights).map(|(value, weight)| weight * value);
            value(seed) + beyond.sum::<f64>()
        };
        let weight = mean(&|shape| shape.weight).clamp(0.0, 1.0) * present.max(0.0);
        if weight <= 0.0 {
            continue;
        }
        let [uu, uv, vu, vv] =
            [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[r, c]| mean(&|s| s.matrix[r][c]));
        let matrix = turned_map([[uu, uv], [vu, vv]], -azimuth_rad);
        let [x, y] = turned(place, -azimuth_rad);
        let placed = |&p: &[f64; 2]| {
            let [u, v] = turned(p, -azimuth_rad);
            [u + x, v + y]
        };
        paths.push(Path {
            polygon: polygon.iter().map(placed).collect(),
            matrix,
            offset: matrix.map(|row| -(row[0] * x + row[1] * y)),
            weight,
            deviation: deviation(
                turned([0, 1].map(|k| mean(&|s| s.astray[k])), -azimuth_rad),
                tau,
                index,
            ),
            passes: seed.passes,
            jones: mean_field(&members, &weights).map(|jones| scaled(jones, -azimuth_rad, weight)),
            cube: seed.cube.map(|cube| turned_cube(cube, -azimuth_rad)),
        });
    }
    Some(paths)
}

/// Returns where the polygons of each family are placed: where one of its cube's families has its
/// seed. Pieces of one cube, which have one fixed point in some direction, then still meet, and
/// pieces of different cubes do not.
fn places(families: &[Vec<(usize, usize)>], seen: &[Vec<PathShape>]) -> Vec<[f64; 2]> {
    const SAME: f64 = 1e-3;
    let fixed = |&(node, path): &(usize, usize)| seen[node][path].fixed;
    let of_one_cube = |a: &[(usize, usize)], b: &[(usize, usize)]| {
        a.iter().any(|own| {
            let other = b.iter().find(|other| other.0 == own.0);
            other.is_some_and(|other| distance(fixed(own), fixed(other)) < SAME)
        })
    };
    let mut places: Vec<[f64; 2]> = Vec::new();
    for (k, family) in families.iter().enumerate() {
        let known = (0..k).find(|&other| of_one_cube(family, &families[other]));
        places.push(known.map_or_else(|| fixed(&family[0]), |other| places[other]));
    }
    places
}

/// Groups the paths of all nodes into families of (node, path): one family is one path of the
/// sheet.
///
/// A family begins at one of the four directions around, at the steepest that has the path. It goes
/// on from there to the next nodes. The steepest is first because cubes of all orientations look
/// alike at normal incidence, and after a wide turn one cube looks like another.
pub(crate) fn families(
    nodes: &[NearDirection],
    seen: &[Vec<PathShape>],
) -> Vec<Vec<(usize, usize)>> {
    let steepness = |index: usize| dot(nodes[index].tau, nodes[index].tau);
    let (mut order, mut rest): (Vec<usize>, Vec<usize>) =
        (0..nodes.len()).partition(|&index| nodes[index].share > 0.0);
    order.sort_by(|&a, &b| steepness(b).total_cmp(&steepness(a)));
    let away = |index: usize| {
        let corners = order
            .iter()
            .map(|&corner| distance(nodes[corner].tau, nodes[index].tau));
        corners.fold(f64::INFINITY, f64::min)
    };
    rest.sort_by(|&a, &b| away(a).total_cmp(&away(b)));
    order.extend(rest);
    // Light of one path hardly turns against the errors of its facets. So exit directions tell
    // paths apart whose polygons are alike, as those of one cube with errors are at its limit.
    let lengths = seen.iter().flatten().map(|s| distance(s.astray, [0.0; 2]));
    let most_astray = lengths.fold(0.0, f64::max);
    let mut families: Vec<Vec<(usize, usize)>> = Vec::new();
    for index in order {
        let mut costs = Vec::new();
        for (which, family) in families.iter().enumerate() {
            // A member that is less than half as steep is too flat to compare with.
            let tells = |&&(node, _): &&(usize, usize)| 4.0 * steepness(node) >= steepness(index);
            let apart = |node: usize| distance(nodes[index].tau, nodes[node].tau);
            let nearest = family
                .iter()
                .filter(tells)
                .min_by(|a, b| apart(a.0).total_cmp(&apart(b.0)));
            let &(like, first) = nearest.unwrap_or(&family[0]);
            let most = FASTEST * apart(like) + SHORT;
            for (path, shape) in seen[index].iter().enumerate() {
                let known = &seen[like][first];
                let unlike = shape.unlike(known);
                // Ideal cells have rounding errors only, which must not break ties.
                let turned = if most_astray > LEAST_ASTRAY {
                    let about = shape.about() - known.about();
                    distance(shape.astray, known.astray).hypot(about) / most_astray
                } else {
                    0.0
                };
                let turns = turned <= TURN * apart(like) + SHORT;
                if unlike <= most && turns && shape.passes == known.passes {
                    costs.push((unlike + FASTEST * turned, which, path));
                }
            }
        }
        let pairs = assigned(costs);
        for &(which, path) in &pairs {
            families[which].push((index, path));
        }
        if nodes[index].share > 0.0 {
            let free = |path: &usize| pairs.iter().all(|(_, taken)| taken != path);
            let new = (0..seen[index].len()).filter(free);
            families.extend(new.map(|path| vec![(index, path)]));
        }
    }
    families
}

#[cfg(test)]
mod tests;
