//! One cube corner up to its planar rim: sharp, with rounded edges, or with a flat facet in place
//! of its apex.

use glam::{DMat3, DVec3};

/// Facets of a cube corner, and the rim that joins the next cube or the land around.
pub(crate) struct CornerFacets {
    /// Positions of the vertices, file units.
    pub positions: Vec<DVec3>,
    /// Facets, counter-clockwise seen from the light.
    pub triangles: Vec<[u32; 3]>,
    /// Vertices of the rim at the ends of edges 1, 2 and 3, counter-clockwise: one if the edge is
    /// sharp, an arc if it is rounded.
    pub rim: [Vec<u32>; 3],
}

impl CornerFacets {
    /// Makes the facets between three edges.
    pub(super) fn sharp([a, b, c]: [DVec3; 3]) -> Self {
        CornerFacets {
            positions: vec![DVec3::ZERO, a, b, c],
            triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1]],
            rim: [vec![1], vec![2], vec![3]],
        }
    }

    /// Makes a corner of which a flat facet cuts off the part `part` of each edge.
    pub(super) fn blunt(legs: [DVec3; 3], part: f64) -> Self {
        let mut positions = legs.map(|leg| leg * part).to_vec();
        positions.extend(legs);
        CornerFacets {
            positions,
            triangles: vec![
                [0, 1, 2],
                [0, 3, 4],
                [0, 4, 1],
                [1, 4, 5],
                [1, 5, 2],
                [2, 5, 3],
                [2, 3, 0],
            ],
            rim: [vec![3], vec![4], vec![5]],
        }
    }

    /// Makes a corner with rounded edges and a rounded apex.
    ///
    /// Each edge is filled by a cylinder of the radius `radius` in `strips` planar strips of equal
    /// angle. The apex is filled by the sphere that touches all three facets, in strips^2
    /// triangles. Strips and triangles have their corners on the cylinders and the sphere, which
    /// touch each facet at a distance `radius` from the other two. What is left of a facet is the
    /// part that is farther than this from both its edges (for right angles).
    pub(super) fn rounded(legs: [DVec3; 3], radius: f64, strips: u32) -> Self {
        let next = |k: usize| (k + 1) % 3;
        let normals = [0, 1, 2].map(|k| legs[k].cross(legs[next(k)]).normalize());
        let rows = DMat3::from_cols(normals[0], normals[1], normals[2]).transpose();
        let centre = rows.inverse() * DVec3::splat(radius);
        // Direction from the middle of the sphere to its patch; `at` are three parts of `strips`,
        // one for each facet.
        let outward = |at: [u32; 3]| match [0, 1, 2].map(|k| at[k] == 0) {
            [true, false, false] => between(normals[1], normals[2], at[2], strips),
            [false, true, false] => between(normals[2], normals[0], at[0], strips),
            [false, false, true] => between(normals[0], normals[1], at[1], strips),
            _ => {
                let weight = at.map(|part| quarter(part, strips).sin());
                let sum = normals[0] * weight[0] + normals[1] * weight[1] + normals[2] * weight[2];
                sum.normalize()
            }
        };
        let mut positions = Vec::new();
        let row = |i: u32| (i * (2 * strips + 3 - i)) / 2;
        let vertex = |[i, j, _]: [u32; 3]| row(i) + j;
        for i in 0..=strips {
            for j in 0..=strips - i {
                positions.push(centre - outward([i, j, strips - i - j]) * radius);
            }
        }
        let mut triangles = Vec::new();
        for i in 0..strips {
            for j in 0..strips - i {
                let k = strips - 1 - i - j;
                triangles.push([[i + 1, j, k], [i, j + 1, k], [i, j, k + 1]].map(vertex));
                if k > 0 {
                    let k = k - 1;
                    let turned = [[i, j + 1, k + 1], [i + 1, j, k + 1], [i + 1, j + 1, k]];
                    triangles.push(turned.map(vertex));
                }
            }
        }
        // Edge k lies between the facets k - 1 and k. Its strips run from the sphere to the rim.
        let rim_normal = (legs[1] - legs[0]).cross(legs[2] - legs[0]);
        let arc = |edge: usize| {
            (0..=strips).map(move |step| {
                let mut at = [0; 3];
                at[(edge + 2) % 3] = strips - step;
                at[edge] = step;
                vertex(at)
            })
        };
        let rim = [0, 1, 2].map(|edge| {
            let foot: Vec<u32> = arc(edge).collect();
            let first = positions.len() as u32;
            for &start in &foot {
                let from = positions[start as usize];
                let way = rim_normal.dot(legs[0] - from) / rim_normal.dot(legs[edge]);
                positions.push(from + legs[edge] * way);
            }
            let top: Vec<u32> = (first..=first + strips).collect();
            for (foot, top) in foot.windows(2).zip(top.windows(2)) {
                triangles.push([foot[1], foot[0], top[0]]);
                triangles.push([foot[1], top[0], top[1]]);
            }
            top
        });
        for facet in 0..3 {
            let mut at = [0; 3];
            at[facet] = strips;
            let (from, to) = (rim[facet][strips as usize], rim[next(facet)][0]);
            triangles.push([vertex(at), from, to]);
        }
        CornerFacets {
            positions,
            triangles,
            rim,
        }
    }
}

/// Returns `part` of `whole` of a right angle, rad.
fn quarter(part: u32, whole: u32) -> f64 {
    std::f64::consts::FRAC_PI_2 * f64::from(part) / f64::from(whole)
}

/// Returns the unit vector at `part` of `whole` of the angle from `from` to `to`.
fn between(from: DVec3, to: DVec3, part: u32, whole: u32) -> DVec3 {
    if part == whole {
        return to;
    }
    let angle = from.angle_between(to);
    let there = f64::from(part) / f64::from(whole) * angle;
    (from * (angle - there).sin() + to * there.sin()) / angle.sin()
}
