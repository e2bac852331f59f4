//! The symmetry of a cell about the sheet's normal, found from its facets, so that only a sector of azimuths is baked.
//!
//! What light meets decides: a cell that falls into bodies ([`bodies::apart`]) has every symmetry that carries its bodies
//! onto copies of each other wherever they lie, so a pair of cubes has the six rotations of its tiling; a periodic cell is
//! compared modulo its lattice; any other one as it is, with its rim.

use crate::beams::exact::MOST_TRIANGLES;
use crate::cell::bodies;
use crate::cell::planes as facet;
use glam::{DMat2, DVec2, DVec3};
use meshes::Cell;
use tables::Symmetry;

/// Corners closer than this coincide, as a part of the cell's extent: files of six digits and of single precision round
/// to less. What moves by it has that part of its light in the wrong place, below all but the exact method's errors.
const SAME: f64 = 1e-6;

/// Rotations looked for; no lattice has more than 6.
const MOST_ROTATIONS: u32 = 12;

/// Facets in all bodies at most: comparisons grow with their square.
const MOST_FACETS: usize = 512;

/// Mirrors are planes of round angles in nearly all designs: within this of a quarter degree they are there, degrees.
const ROUND_DEG: f64 = 1e-4;

/// The symmetry of `cell`; [`Symmetry::NONE`] where there is none, where the cell has too many facets to look, and where they
/// stand for curved faces.
pub fn of(cell: &Cell) -> Symmetry {
    if cell.normals.is_some() || !cell.glass.is_empty() {
        return Symmetry::NONE;
    }
    let shapes = shapes(cell);
    let facets: usize = shapes.iter().map(|shape| shape.facets.len()).sum();
    if facets == 0 || facets > MOST_FACETS {
        return Symmetry::NONE;
    }
    let extent = shapes.iter().map(Shape::extent).fold(1.0, f64::max);
    let holds = |map: DMat2| {
        let onto = |from: &Shape| {
            shapes
                .iter()
                .any(|to| from.maps_onto(to, map, SAME * extent))
        };
        shapes.iter().all(onto)
    };
    let rotations = (2..=MOST_ROTATIONS)
        .rev()
        .find(|&n| holds(DMat2::from_angle(std::f64::consts::TAU / f64::from(n))))
        .unwrap_or(1);
    // Mirror planes are half a rotation apart.
    let step = 180.0 / f64::from(rotations);
    let mut mirrors: Vec<f64> = mirrors_deg(&shapes)
        .into_iter()
        // -0 is 0.
        .map(|mirror| rounded(mirror.rem_euclid(step)).rem_euclid(step) + 0.0)
        .collect();
    mirrors.sort_by(f64::total_cmp);
    mirrors.dedup();
    let reflection = |mirror_deg: f64| {
        let (sin, cos) = (2.0 * mirror_deg).to_radians().sin_cos();
        DMat2::from_cols(DVec2::new(cos, sin), DVec2::new(sin, -cos))
    };
    Symmetry {
        rotations,
        mirror_deg: mirrors
            .into_iter()
            .find(|&mirror| holds(reflection(mirror))),
    }
}

fn rounded(angle_deg: f64) -> f64 {
    let round = (4.0 * angle_deg).round() / 4.0;
    if (angle_deg - round).abs() < ROUND_DEG {
        round
    } else {
        angle_deg
    }
}

/// Azimuths of the planes that would carry one facet's normal onto another's, degrees.
fn mirrors_deg(shapes: &[Shape]) -> Vec<f64> {
    let slopes = || {
        let facets = shapes.iter().flat_map(|shape| &shape.facets);
        let slopes = facets.map(|facet| facet.normal.truncate());
        slopes.filter(|slope| slope.length() > 0.1)
    };
    let azimuth = |slope: DVec2| slope.y.atan2(slope.x).to_degrees();
    let first = slopes().next().map(azimuth);
    first.map_or(Vec::new(), |first| {
        slopes()
            .map(|other| 0.5 * (first + azimuth(other)))
            .collect()
    })
}

/// What light meets, and how often.
struct Shape {
    facets: Vec<facet::Facet>,
    /// Empty where there is a lattice.
    rim: Vec<DVec3>,
    lattice: Option<DMat2>,
    copies: usize,
}

fn shapes(cell: &Cell) -> Vec<Shape> {
    let rim = |entrance: &meshes::Entrance| -> Vec<DVec3> {
        let corners = entrance.polygon.iter().map(|p| p.extend(entrance.height));
        corners.collect()
    };
    if let Some([a, b]) = cell.entrance.lattice {
        return vec![Shape {
            facets: facet::join(&cell.facets),
            rim: Vec::new(),
            lattice: Some(DMat2::from_cols(a, b)),
            copies: 1,
        }];
    }
    let whole = || Shape {
        facets: facet::join(&cell.facets),
        rim: rim(&cell.entrance),
        lattice: None,
        copies: 1,
    };
    match bodies::apart(cell) {
        Ok(kinds) => kinds
            .iter()
            .map(|kind| Shape {
                facets: facet::join(&kind.facets),
                rim: rim(&kind.entrance),
                lattice: None,
                copies: kind.places.len(),
            })
            .collect(),
        Err(_) if cell.facets.len() > MOST_TRIANGLES => Vec::new(),
        Err(_) => vec![whole()],
    }
}

fn middle(corners: &[DVec3]) -> DVec3 {
    corners.iter().sum::<DVec3>() / corners.len() as f64
}

impl Shape {
    fn extent(&self) -> f64 {
        let corners = self.facets.iter().flat_map(|facet| &facet.corners);
        corners.map(|x| x.length()).fold(0.0, f64::max)
    }

    /// All polygons: facets and rim.
    fn polygons(&self) -> impl Iterator<Item = &[DVec3]> {
        let facets = self.facets.iter().map(|facet| facet.corners.as_slice());
        facets.chain((!self.rim.is_empty()).then_some(self.rim.as_slice()))
    }

    /// Whether `map` and a translation carry this shape onto `other`.
    fn maps_onto(&self, other: &Shape, map: DMat2, same: f64) -> bool {
        if self.copies != other.copies || self.facets.len() != other.facets.len() {
            return false;
        }
        let turn = |x: DVec3| (map * x.truncate()).extend(x.z);
        let moves: Vec<DVec3> = match &self.lattice {
            Some(lattice) => {
                let image = lattice.inverse() * map * *lattice;
                let whole = |x: DVec2| (x - x.round()).abs().max_element() <= same;
                if !(whole(image.x_axis) && whole(image.y_axis)) {
                    return false;
                }
                // The first facet lands on one of them.
                let from = turn(middle(&self.facets[0].corners));
                let onto = other
                    .facets
                    .iter()
                    .map(|facet| middle(&facet.corners) - from);
                onto.collect()
            }
            None => {
                let centre = |shape: &Shape| {
                    let middles = shape.polygons().map(middle);
                    middles.sum::<DVec3>() / shape.polygons().count() as f64
                };
                vec![centre(other) - turn(centre(self))]
            }
        };
        moves.into_iter().any(|by| {
            self.polygons().all(|polygon| {
                let image: Vec<DVec3> = polygon.iter().map(|&x| turn(x) + by).collect();
                let lands = |target: &[DVec3]| self.coincide(&image, target, same);
                other.polygons().any(lands)
            })
        })
    }

    /// Whether two polygons have the same corners, up to a lattice vector.
    fn coincide(&self, one: &[DVec3], other: &[DVec3], same: f64) -> bool {
        let apart = middle(other) - middle(one);
        let step = self.lattice.map_or(DVec2::ZERO, |lattice| {
            lattice * (lattice.inverse() * apart.truncate()).round()
        });
        let near = |a: DVec3, b: DVec3| (a + step.extend(0.0) - b).length() <= same;
        let has = |a: &DVec3| other.iter().any(|&b| near(*a, b));
        one.len() == other.len() && one.iter().all(has)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meshes::design::{Design, Shape as Form};

    fn cell(change: impl FnOnce(&mut Design), form: Form, glb: bool) -> Cell {
        let mut design = Design::new(form);
        change(&mut design);
        let mesh = design.mesh().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let file = folder
            .path()
            .join(if glb { "cell.glb" } else { "cell.obj" });
        let bytes = match glb {
            true => meshes::write::glb(&mesh),
            false => meshes::write::obj(&mesh).into_bytes(),
        };
        std::fs::write(&file, bytes).unwrap();
        meshes::load_cell(&file, &meshes::CellOptions::default()).unwrap()
    }

    #[test]
    fn designs_have_the_symmetry_that_they_were_drawn_with() {
        let equal = |design: &mut Design| design.dihedral_error_rad = [1e-3; 3];
        let one = |design: &mut Design| design.dihedral_error_rad = [1e-3, 0.0, 0.0];
        let unequal = |design: &mut Design| design.dihedral_error_rad = [1e-3, 2e-3, 3e-3];
        let canted = |design: &mut Design| design.cant_rad = 0.1;
        type Change = fn(&mut Design);
        let cases: [(Form, Change, bool, u32, bool); 11] = [
            (Form::Triangular, |_| (), false, 3, true),
            (Form::TriangularPair, |_| (), false, 6, true),
            (Form::FullCube, |_| (), false, 3, true),
            (Form::TriangularPair, equal, false, 6, true),
            // A mirror through the edge that has the error, and the half turn of the pair.
            (Form::TriangularPair, one, false, 2, true),
            (Form::TriangularPair, unequal, false, 2, false),
            (Form::Triangular, unequal, false, 1, false),
            (Form::Canted, canted, false, 2, true),
            // Where single precision rounds, the rims are no longer in one plane, so that the pair is one body with its own rim.
            (Form::Triangular, |_| (), true, 3, true),
            (Form::TriangularPair, |_| (), true, 6, true),
            (Form::TriangularPair, equal, true, 2, true),
        ];
        let mut tried = 0;
        for (form, change, glb, rotations, mirror) in cases {
            let found = of(&cell(change, form, glb));
            let name = (form, rotations, mirror, glb);
            assert_eq!(found.rotations, rotations, "{name:?}: {found:?}");
            assert_eq!(found.mirror_deg.is_some(), mirror, "{name:?}: {found:?}");
            tried += 1;
        }
        println!("{tried} cells");
        assert_eq!(tried, 11);
    }
}
