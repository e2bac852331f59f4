//! Dihedral errors of any cube corner: the facets of a cell are bent by a linear map.
//!
//! A corner is three planes at right angles. A linear map with the strain
//! S = -1/2 sum e_ij (n_i n_j' + n_j n_i') changes the dihedral angle between the planes i and j by
//! e_ij, to first order; a few corrections make it exact. A rotation and a change of size are added,
//! so that the entrance plane stays where it is. So whole facets stay plane, and rims and lattices
//! stay closed. The outline changes by the error times the edge length.

use crate::cell::{Part, PlanarFacet};
use glam::{DMat2, DMat3, DVec3};

/// Greatest sine of the error of an angle that was meant to be a right one (5.7 degrees).
const MEANT: f64 = 0.1;

/// Largest angle between two facets of one plane, rad.
const SAME_PLANE: f64 = 1e-6;

/// Largest number of planes of a part in which a corner is looked for.
const MOST_PLANES: usize = 64;

/// Corrections of the map; each adds as many digits as the first guess has.
const CORRECTIONS: u32 = 6;

/// The three planes of a cube corner in a part of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Corner {
    /// Unit normals towards the light.
    normals: [DVec3; 3],
    /// Point where the planes meet, edge lengths.
    apex: DVec3,
}

/// Pairs of planes, in the order of the three errors.
const PAIRS: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

impl Corner {
    /// Finds the corner of a part, or returns `None` unless there is exactly one.
    pub(crate) fn of(part: &Part) -> Option<Corner> {
        let mut planes: Vec<(DVec3, f64)> = Vec::new();
        for facet in &part.facets {
            let same = |(normal, _): &(DVec3, f64)| normal.distance(facet.normal) < SAME_PLANE;
            if !planes.iter().any(same) {
                planes.push((facet.normal, facet.offset));
            }
        }
        if planes.len() > MOST_PLANES {
            return None;
        }
        let right = |i: usize, j: usize| planes[i].0.dot(planes[j].0).abs() < MEANT;
        let mut found = None;
        for i in 0..planes.len() {
            for j in (0..i).filter(|&j| right(i, j)) {
                for k in (0..j).filter(|&k| right(i, k) && right(j, k)) {
                    if found.is_some() {
                        return None;
                    }
                    let (normals, offsets): (Vec<DVec3>, Vec<f64>) =
                        [k, j, i].map(|at| planes[at]).into_iter().unzip();
                    let rows = DMat3::from_cols(normals[0], normals[1], normals[2]).transpose();
                    let apex = rows.inverse() * DVec3::new(offsets[0], offsets[1], offsets[2]);
                    let normals = [normals[0], normals[1], normals[2]];
                    found = Some(Corner { normals, apex });
                }
            }
        }
        found
    }

    /// Returns the errors of the three dihedral angles of the planes 1 and 2, 2 and 3, 3 and 1, rad,
    /// after a linear map. Positive errors are wider than 90 degrees.
    fn errors(&self, map: DMat3) -> [f64; 3] {
        let by = map.inverse().transpose();
        let turned = self.normals.map(|normal| (by * normal).normalize());
        PAIRS.map(|[i, j]| turned[i].dot(turned[j]).asin())
    }

    /// Returns the errors of the three dihedral angles of the cell as it is, rad.
    pub(crate) fn own_errors(&self) -> [f64; 3] {
        self.errors(DMat3::IDENTITY)
    }

    /// Returns the linear map that adds `errors`, rad, to the three dihedral angles.
    fn map(&self, errors: [f64; 3]) -> DMat3 {
        let before = self.errors(DMat3::IDENTITY);
        let mut shears = errors.map(|error| -0.5 * error);
        for _ in 0..CORRECTIONS {
            let found = self.errors(self.strained(shears));
            for k in 0..3 {
                shears[k] -= 0.5 * (before[k] + errors[k] - found[k]);
            }
        }
        self.strained(shears)
    }

    /// Returns the map of a strain whose parts in the planes of two normals are `shears`. Its last
    /// row is that of the unit matrix, so that it keeps heights.
    fn strained(&self, shears: [f64; 3]) -> DMat3 {
        let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
        let mut strain = DMat3::ZERO;
        for (shear, [i, j]) in shears.into_iter().zip(PAIRS) {
            let [a, b] = [self.normals[i], self.normals[j]];
            strain += (outer(a, b) + outer(b, a)) * shear;
        }
        // The size makes up for the strain along the height, and a rotation takes the rest of the
        // last row to the last column.
        strain -= DMat3::IDENTITY * strain.z_axis.z;
        let tilt = strain.z_axis;
        strain.z_axis = DVec3::new(2.0 * tilt.x, 2.0 * tilt.y, 0.0);
        (strain.x_axis.z, strain.y_axis.z) = (0.0, 0.0);
        DMat3::IDENTITY + strain
    }

    /// Returns the part with `errors`, rad, added to the three dihedral angles of its corner.
    ///
    /// Returns `None` if a facet has lost its area.
    pub(crate) fn bent(&self, part: &Part, errors: [f64; 3]) -> Option<Part> {
        if errors == [0.0; 3] {
            return Some(part.clone());
        }
        let map = self.map(errors);
        let moved = |x: DVec3| (self.apex + map * (x - self.apex)).with_z(x.z);
        let facet = |facet: &PlanarFacet| {
            let corners = facet.corners.iter().map(|&x| moved(x)).collect();
            PlanarFacet::new(corners)
        };
        let mut entrance = part.entrance.clone();
        let height = entrance.height;
        for p in &mut entrance.polygon {
            *p = moved(p.extend(height)).truncate();
        }
        let flat = DMat2::from_cols(map.x_axis.truncate(), map.y_axis.truncate());
        entrance.lattice = entrance.lattice.map(|sides| sides.map(|side| flat * side));
        Some(Part {
            facets: part.facets.iter().map(facet).collect::<Option<_>>()?,
            entrance,
            copies: part.copies,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::Prepared;
    use meshes::design::{Design, Shape};

    /// Errors of a bent cell, measured on its facets, are those that were asked for, on top of its
    /// own; whatever the cant of the cube. Heights stay, and the outline moves by the error.
    #[test]
    fn a_bent_corner_has_the_errors_asked_for() {
        let mut cases = 0;
        for shape in [Shape::Triangular, Shape::Canted, Shape::FullCube] {
            let design = Design {
                dihedral_error_rad: [2e-4, -1e-4, 3e-4],
                ..Design::new(shape)
            };
            let mesh = design.mesh().expect("a design");
            let cell = meshes::normalise(&mesh, "a.obj".as_ref(), &meshes::CellOptions::default());
            let prepared = Prepared::new(cell.expect("a cell"));
            for part in prepared.cubes().expect("few facets") {
                let corner = Corner::of(&part).expect("one corner");
                let own = corner.own_errors();
                // The planes come in another order than the edges.
                let sum: f64 = own.iter().sum();
                assert!((sum - 4e-4).abs() < 1e-12, "{shape:?}: {own:?}");
                for wanted in [[1e-3, 0.0, 0.0], [-2e-3, 5e-3, 1e-3], [1e-2; 3]] {
                    let bent = corner.bent(&part, wanted).expect("facets with area");
                    let found = Corner::of(&bent).expect("one corner").own_errors();
                    for k in 0..3 {
                        let off = found[k] - own[k] - wanted[k];
                        assert!(off.abs() < 1e-12, "{shape:?}, {wanted:?}: {off:e}");
                    }
                    let [before, after] = [&part, &bent].map(|part| {
                        let corners = part.facets.iter().flat_map(|facet| &facet.corners);
                        corners.copied().collect::<Vec<DVec3>>()
                    });
                    let most = wanted
                        .iter()
                        .fold(0.0_f64, |most, error| most.max(error.abs()));
                    for (a, b) in before.iter().zip(&after) {
                        assert!(a.z == b.z && a.distance(*b) < 5.0 * most);
                    }
                    cases += 1;
                }
            }
        }
        assert_eq!(cases, 3 * (1 + 2 + 1));
    }
}
