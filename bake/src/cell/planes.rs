//! Convex planar facets, made of the triangles of the mesh.
//!
//! Triangles that share an edge and a plane are joined if the result is convex. So a square face is
//! one facet and not two, and a beam that it reflects stays in one piece.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use crate::geometry::polygon;
use crate::optics::{Incidence, triangle};

/// Largest distance of a corner from the plane of a facet that it joins, edge lengths. It is far
/// above the rounding of a placed mesh (1e-16) and far below any dihedral error that anyone could
/// ask for (1e-9 rad).
const COPLANAR: f64 = 1e-13;

/// A convex planar mirror, cell frame, edge lengths.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlanarFacet {
    /// Corners, counter-clockwise seen from the light.
    pub corners: Vec<DVec3>,
    /// Unit normal towards the light.
    pub normal: DVec3,
    /// Offset of the plane normal.x = offset, edge lengths.
    pub offset: f64,
    /// True for the back of a mirror, where light ends.
    pub dark: bool,
}

impl PlanarFacet {
    /// Makes the facet of `corners`, or `None` if they have no area.
    pub(crate) fn new(corners: Vec<DVec3>) -> Option<Self> {
        let normal = triangle::normal(&corners)?;
        let centre = corners.iter().sum::<DVec3>() / corners.len() as f64;
        Some(PlanarFacet {
            normal,
            offset: normal.dot(centre),
            corners,
            dark: false,
        })
    }

    /// Returns the back of the facet, which light from behind meets.
    pub(crate) fn back(&self) -> PlanarFacet {
        PlanarFacet {
            corners: self.corners.iter().rev().copied().collect(),
            normal: -self.normal,
            offset: -self.offset,
            dark: true,
        }
    }

    /// Returns the area of the facet's projection along n, square edge lengths.
    pub(crate) fn area_from_above(&self) -> f64 {
        let flat: Vec<DVec2> = self.corners.iter().map(|x| x.truncate()).collect();
        polygon::area(&flat)
    }

    /// Turns the facet into the frame of the light: x = u, y = v, z = n.
    pub(crate) fn turned(&self, light: &Incidence) -> PlanarFacet {
        let turn = |x: DVec3| light.to_frame(x.truncate()).extend(x.z);
        PlanarFacet {
            corners: self.corners.iter().map(|&x| turn(x)).collect(),
            normal: turn(self.normal),
            offset: self.offset,
            dark: self.dark,
        }
    }

    fn is_convex(&self) -> bool {
        let n = self.corners.len();
        (0..n).all(|i| {
            let (a, b, c) = (
                self.corners[i],
                self.corners[(i + 1) % n],
                self.corners[(i + 2) % n],
            );
            let (first, second) = (b - a, c - b);
            let size = first.length() * second.length();
            let turn = first.cross(second).dot(self.normal);
            turn > 1e-12 * size || (turn > -1e-12 * size && first.dot(second) > 0.0)
        })
    }
}

/// Joins coplanar neighbours into facets, in the order of the triangles. Triangles without area are
/// dropped.
pub(crate) fn join(triangles: &[[DVec3; 3]]) -> Vec<PlanarFacet> {
    let mut facets: Vec<Option<PlanarFacet>> = triangles
        .iter()
        .map(|t| PlanarFacet::new(t.to_vec()))
        .collect();
    let mut owner: HashMap<[PositionBits; 2], usize> = HashMap::new();
    for (i, facet) in facets.iter().enumerate() {
        for edge in facet.iter().flat_map(|f| edge_keys(&f.corners)) {
            owner.insert(edge, i);
        }
    }
    for i in 0..facets.len() {
        while let Some((j, joined)) = neighbour_to_join(&facets, &owner, i) {
            for edge in edge_keys(&joined.corners) {
                owner.insert(edge, i);
            }
            facets[i] = Some(joined);
            facets[j] = None;
        }
    }
    facets.into_iter().flatten().collect()
}

fn neighbour_to_join(
    facets: &[Option<PlanarFacet>],
    owner: &HashMap<[PositionBits; 2], usize>,
    i: usize,
) -> Option<(usize, PlanarFacet)> {
    let facet = facets[i].as_ref()?;
    edge_keys(&facet.corners)
        .enumerate()
        .find_map(|(edge, [a, b])| {
            let j = *owner.get(&[b, a])?;
            let other = facets[j].as_ref().filter(|_| j != i)?;
            let joined = join_at(facet, edge, other, [b, a])?;
            Some((j, joined))
        })
}

/// Returns the union of two facets across the edge number `edge` of `facet`, or `None` if it is not
/// planar and convex.
fn join_at(
    facet: &PlanarFacet,
    edge: usize,
    other: &PlanarFacet,
    reversed: [PositionBits; 2],
) -> Option<PlanarFacet> {
    let coplanar = |a: &PlanarFacet, b: &PlanarFacet| {
        b.corners
            .iter()
            .all(|x| (a.normal.dot(*x) - a.offset).abs() <= COPLANAR)
    };
    if facet.normal.dot(other.normal) <= 0.0 || !coplanar(facet, other) || !coplanar(other, facet) {
        return None;
    }
    let (n, m) = (facet.corners.len(), other.corners.len());
    let start = edge_keys(&other.corners).position(|key| key == reversed)?;
    let mut corners: Vec<DVec3> = (0..n).map(|k| facet.corners[(edge + 1 + k) % n]).collect();
    corners.extend((0..m - 2).map(|k| other.corners[(start + 2 + k) % m]));
    // Two facets that share a chain of edges leave a spur a-b-a behind.
    while let Some(spur) = (0..corners.len()).find(|&k| {
        let n = corners.len();
        n > 3 && key(corners[(k + n - 1) % n]) == key(corners[(k + 1) % n])
    }) {
        let next = (spur + 1) % corners.len();
        corners.remove(spur.max(next));
        corners.remove(spur.min(next));
    }
    (corners.len() >= 3)
        .then(|| PlanarFacet::new(corners))
        .flatten()
        .filter(PlanarFacet::is_convex)
}

/// Returns the keys of both ends of each edge.
pub(crate) fn edge_keys(corners: &[DVec3]) -> impl Iterator<Item = [PositionBits; 2]> + '_ {
    (0..corners.len()).map(|i| [key(corners[i]), key(corners[(i + 1) % corners.len()])])
}

/// The bits of a position.
pub(crate) type PositionBits = [u64; 3];

/// Returns the bits of a position. Adding 0 turns -0 into 0, which is the same place.
fn key(x: DVec3) -> PositionBits {
    (x + DVec3::ZERO).to_array().map(f64::to_bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_of_four_triangles_is_one_facet() {
        let centre = DVec3::new(0.5, 0.5, 0.0);
        let corner = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        let fan: Vec<_> = (0..4)
            .map(|i| [corner[i], corner[(i + 1) % 4], centre])
            .collect();
        let facets = join(&fan);
        assert_eq!(facets.len(), 1);
        assert_eq!(facets[0].normal, DVec3::Z);
        assert!(corner.iter().all(|c| facets[0].corners.contains(c)));
    }

    #[test]
    fn a_bend_of_a_nanoradian_and_a_dent_are_not_joined() {
        let quad = |lift: f64, far: f64| {
            let (a, b, c) = (DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0));
            [[a, b, c], [a, c, DVec3::new(1.0 - far, far, lift)]]
        };
        assert_eq!(join(&quad(0.0, 1.0)).len(), 1);
        assert_eq!(join(&quad(1e-9, 1.0)).len(), 2, "bent");
        let dent = [
            [DVec3::ZERO, DVec3::X, DVec3::new(0.2, 0.2, 0.0)],
            [DVec3::ZERO, DVec3::new(0.2, 0.2, 0.0), DVec3::Y],
        ];
        assert_eq!(join(&dent).len(), 2, "not convex");
        assert!(
            join(&[[DVec3::ZERO, DVec3::X, DVec3::X * 2.0]]).is_empty(),
            "no area"
        );
    }
}
