//! Recesses: surfaces whose whole rim lies in the entrance plane.
//!
//! Light that enters a recess leaves through the same opening, whatever the lattice around it. So a
//! periodic cell of recesses needs no neighbours, and grazing light needs no long search for them.

use std::collections::HashMap;

use glam::DVec2;

use crate::cell::planes::{PlanarFacet, PositionBits, edge_keys};
use crate::geometry::{Polygon, polygon};

/// Largest distance of a rim corner from the entrance plane, edge lengths. It allows for the
/// rounding of a placed mesh and no more.
const IN_PLANE: f64 = 1e-12;
/// Largest relative difference between the area of the openings and that of the entrance that
/// counts as none.
const SAME_AREA: f64 = 1e-9;

/// Returns the openings of the recesses in the plane z = `height`.
///
/// Returns `None` if the rim leaves that plane or the openings are not the whole entrance.
pub(crate) fn openings(
    facets: &[PlanarFacet],
    height: f64,
    entrance_area: f64,
) -> Option<Vec<Polygon>> {
    let mut edges: HashMap<[PositionBits; 2], (DVec2, DVec2)> = HashMap::new();
    let mut order = Vec::new();
    for facet in facets {
        for (i, edge) in edge_keys(&facet.corners).enumerate() {
            let (a, b) = (
                facet.corners[i],
                facet.corners[(i + 1) % facet.corners.len()],
            );
            if edges.remove(&[edge[1], edge[0]]).is_none() {
                edges.insert(edge, (a.truncate(), b.truncate()));
                order.push((edge, a, b));
            }
        }
    }
    order.retain(|(edge, ..)| edges.contains_key(edge));
    if order
        .iter()
        .any(|(_, a, b)| (a.z - height).abs() > IN_PLANE || (b.z - height).abs() > IN_PLANE)
    {
        return None;
    }
    let mut loops = Vec::new();
    for (edge, ..) in order {
        loops.extend(
            edges
                .remove(&edge)
                .map(|(start, next)| follow(edge, start, next, &mut edges)),
        );
    }
    let area: f64 = loops.iter().map(|opening| polygon::area(opening)).sum();
    let all_open = loops.iter().all(|opening| polygon::area(opening) > 0.0);
    (all_open && (area / entrance_area - 1.0).abs() <= SAME_AREA).then_some(loops)
}

/// Returns the closed loop that begins with the edge `first`, from `start` to `next`, and removes
/// its edges from `edges`.
fn follow(
    first: [PositionBits; 2],
    start: DVec2,
    next: DVec2,
    edges: &mut HashMap<[PositionBits; 2], (DVec2, DVec2)>,
) -> Polygon {
    let mut corners = vec![start, next];
    let mut at = first[1];
    while at != first[0] {
        let [.., before, here] = corners[..] else {
            break;
        };
        // If openings touch at a corner, the sharpest turn to the left stays with the same opening.
        let turn = |to: DVec2| (here - before).angle_to(to - here);
        let leaving = edges.iter().filter(|(edge, _)| edge[0] == at);
        let Some((&edge, &(_, to))) = leaving.max_by(|a, b| turn(a.1.1).total_cmp(&turn(b.1.1)))
        else {
            break;
        };
        edges.remove(&edge);
        at = edge[1];
        if at != first[0] {
            corners.push(to);
        }
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::planes::join;
    use glam::DVec3;

    #[test]
    fn a_corner_is_a_pit_and_one_with_a_lifted_rim_is_not() {
        let ends = [DVec3::X, DVec3::Y, DVec3::Z];
        // The frame has the apex below: z grows along (1, 1, 1). Only the height of the rim matters
        // here.
        let frame = |x: DVec3| {
            DVec3::new(
                (x.x - x.y) / 2_f64.sqrt(),
                (x.x + x.y - 2.0 * x.z) / 6_f64.sqrt(),
                x.dot(DVec3::ONE),
            )
        };
        let facets = |ends: [DVec3; 3]| {
            join(&[0, 1, 2].map(|i| [DVec3::ZERO, frame(ends[i]), frame(ends[(i + 1) % 3])]))
        };
        let area = 3_f64.sqrt() / 2.0;
        let found = openings(&facets(ends), 1.0, area).expect("a recess");
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].len(), 3);
        assert!(
            openings(&facets(ends), 1.0, 1.1 * area).is_none(),
            "not the whole entrance"
        );
        assert!(
            openings(&facets([DVec3::X * 1.001, DVec3::Y, DVec3::Z]), 1.0, area).is_none(),
            "not planar"
        );
    }

    /// Two triangular recesses touch at a corner, in every direction from the origin and turned by
    /// every angle in steps of 15 degrees. Each keeps its own three sides.
    #[test]
    fn pits_that_touch_at_a_corner_stay_two() {
        let mut cases = 0;
        for step in 0..24 {
            let turn = DVec2::from_angle(f64::from(step) * 15_f64.to_radians());
            for away in [DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y] {
                let place = |x: f64, y: f64| 3.0 * away + turn.rotate(DVec2::new(x, y));
                let touching = place(0.0, 0.0);
                let recesses = [
                    [place(1.0, -1.0), place(1.0, 1.0), touching],
                    [place(-1.0, 1.0), place(-1.0, -1.0), touching],
                ];
                let triangles = recesses.iter().flat_map(|recess| {
                    let bottom = ((recess[0] + recess[1] + recess[2]) / 3.0).extend(-1.0);
                    [0, 1, 2].map(|i| {
                        [
                            bottom,
                            recess[i].extend(0.0),
                            recess[(i + 1) % 3].extend(0.0),
                        ]
                    })
                });
                let facets = join(&triangles.collect::<Vec<_>>());
                let found = openings(&facets, 0.0, 2.0).expect("two recesses");
                let corners: Vec<usize> = found.iter().map(Vec::len).collect();
                assert_eq!(corners, [3, 3], "{step} {away}");
                cases += 1;
            }
        }
        assert_eq!(cases, 24 * 4);
    }
}
