//! A cell that is dissected once: its bodies, its planar facets, its symmetry.

use crate::cell::bodies::{Kind, Whole};
use crate::cell::body::Part;
use crate::cell::planar::{ExactCell, NO_PLANES};
use crate::cell::{bodies, symmetry};
use meshes::Cell;
use std::sync::OnceLock;
use tables::Symmetry;

/// A cell and the facts that its mesh tells: bodies, planar facets, symmetry.
///
/// Each fact is found at most once, when it is first asked for.
#[derive(Debug, Clone)]
pub struct Prepared {
    cell: Cell,
    /// Bodies of the cell by kind, however few facets it has, or why there are none.
    apart: Result<Vec<Kind>, Whole>,
    parts: OnceLock<Option<Vec<Part>>>,
    exact: OnceLock<Result<ExactCell, String>>,
    symmetry: OnceLock<Symmetry>,
}

impl Prepared {
    /// Takes the cell apart into bodies if that is possible.
    pub fn new(cell: Cell) -> Self {
        Prepared {
            apart: bodies::apart(&cell),
            cell,
            parts: OnceLock::new(),
            exact: OnceLock::new(),
            symmetry: OnceLock::new(),
        }
    }

    /// Returns the cell itself.
    pub fn cell(&self) -> &Cell {
        &self.cell
    }

    /// Returns the kinds of bodies that the cell is traced as, one body of each kind.
    ///
    /// # Errors
    ///
    /// Returns [`Whole`], the reason, if the cell is traced as a whole.
    pub(crate) fn kinds(&self) -> Result<&[Kind], Whole> {
        match &self.apart {
            Err(whole @ (Whole::Curved | Whole::Glass | Whole::Periodic)) => Err(*whole),
            _ if self.is_small() => Err(Whole::Small),
            Err(whole) => Err(*whole),
            Ok(kinds) => Ok(kinds),
        }
    }

    /// Returns the cell in the form that the exact method takes.
    ///
    /// # Errors
    /// Says why not, as part of a sentence: the facets have normals from the file, the cell is one
    /// piece of too many triangles, or it has too many planar facets.
    pub(crate) fn exact(&self) -> Result<&ExactCell, &str> {
        let exact = self.exact.get_or_init(|| {
            if self.cell.normals.is_some() {
                return Err(format!("--normals file {NO_PLANES}"));
            }
            let parts = self.parts().ok_or_else(|| {
                let triangles = self.cell.facets.len();
                format!(
                    "the cell has {triangles} triangles in one piece and the exact method takes at \
                    most {MOST_TRIANGLES}; give --method rays"
                )
            })?;
            ExactCell::new(parts)
        });
        exact.as_ref().map_err(String::as_str)
    }

    /// Returns the symmetry of the cell about the sheet's normal.
    ///
    /// It is [`Symmetry::NONE`] if the cell has none, if it has too many facets to look, or if its
    /// facets stand for curved faces or for surfaces of glass.
    pub fn symmetry(&self) -> Symmetry {
        *self.symmetry.get_or_init(|| {
            if self.cell.normals.is_some() || !self.cell.glass.is_empty() {
                return Symmetry::NONE;
            }
            let periodic = self.cell.entrance.lattice.is_some();
            match (&self.apart, self.parts()) {
                // Two cubes are traced as a whole, but their order makes no difference to light.
                (Ok(kinds), _) if self.is_small() => {
                    symmetry::of(&kinds.iter().map(Part::of).collect::<Vec<_>>())
                }
                (_, Some(parts)) => symmetry::of(parts),
                (_, None) if periodic => symmetry::of(&[Part::whole(&self.cell)]),
                (_, None) => Symmetry::NONE,
            }
        })
    }

    /// Returns the parts of the cell, one for each kind of cube even if it has few facets, or `None`
    /// if joining its triangles would take minutes.
    pub(crate) fn cubes(&self) -> Option<Vec<Part>> {
        match &self.apart {
            Ok(kinds) => Some(kinds.iter().map(Part::of).collect()),
            Err(_) => self.parts().map(<[Part]>::to_vec),
        }
    }

    /// Returns the number of separate cubes of the cell and of those that differ, or `None` if it is
    /// one piece.
    pub(crate) fn cubes_apart(&self) -> Option<[usize; 2]> {
        let kinds = self.apart.as_ref().ok()?;
        let cubes = kinds.iter().map(|kind| kind.places.len()).sum();
        Some([cubes, kinds.len()])
    }

    /// Returns whether the cell has too few facets to be worth taking apart.
    fn is_small(&self) -> bool {
        self.cell.facets.len() < SMALL
    }

    /// Returns what light meets, in planar facets, or `None` if joining the triangles would take
    /// minutes.
    fn parts(&self) -> Option<&[Part]> {
        let parts = self.parts.get_or_init(|| match self.kinds() {
            Ok(kinds) => Some(kinds.iter().map(Part::of).collect()),
            Err(_) if self.cell.facets.len() > MOST_TRIANGLES => None,
            Err(_) => Some(vec![Part::whole(&self.cell)]),
        });
        parts.as_deref()
    }
}

/// Least number of facets from which the hierarchy is faster than a loop over all facets, and a
/// cell is worth taking apart.
///
/// Measured ray by ray, in million rays/s on 1 thread, loop against hierarchy:
/// 6 facets 5.0 against 2.9, 24 facets 2.0 against 2.6, 54 facets 1.0 against 2.0.
pub(crate) const SMALL: usize = 24;

/// Largest number of facets of a body that rays cross as a program, many rays side by side.
pub(crate) const PROGRAM_FACETS: usize = 16;

/// Largest number of planar facets that the exact method takes, after joining coplanar triangles.
///
/// They are the facets of a cell, or of one body of each kind if the cell is taken apart.
pub(crate) const MOST_FACETS: usize = 6144;

/// Largest number of planar facets of one body that the exact method takes. The work grows with
/// their square.
pub(crate) const MOST_FACETS_OF_BODY: usize = 2048;

/// Largest number of triangles of a cell that is not taken apart. Joining those of a plane takes a
/// time that grows with their square.
pub(crate) const MOST_TRIANGLES: usize = 1 << 14;

/// Largest error of an exact mean over azimuths: the L1 norm of eta x histogram together with the
/// shares of the fates.
pub(crate) const MEAN_ERROR: f64 = 1e-4;

#[cfg(test)]
mod tests {
    use super::*;
    use meshes::design::{Design, Shape};

    fn cell(change: impl FnOnce(&mut Design), form: Shape, glb: bool) -> Cell {
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
        let cases: [(Shape, Change, bool, u32, bool); 11] = [
            (Shape::Triangular, |_| (), false, 3, true),
            (Shape::TriangularPair, |_| (), false, 6, true),
            (Shape::FullCube, |_| (), false, 3, true),
            (Shape::TriangularPair, equal, false, 6, true),
            // One mirror plane through the edge that has the error, and the half turn of the pair.
            (Shape::TriangularPair, one, false, 2, true),
            (Shape::TriangularPair, unequal, false, 2, false),
            (Shape::Triangular, unequal, false, 1, false),
            (Shape::Canted, canted, false, 2, true),
            // Single precision moves the rims out of one plane, so that the pair is one body with
            // its own rim.
            (Shape::Triangular, |_| (), true, 3, true),
            (Shape::TriangularPair, |_| (), true, 6, true),
            (Shape::TriangularPair, equal, true, 2, true),
        ];
        let mut tried = 0;
        for (form, change, glb, rotations, mirror) in cases {
            let found = Prepared::new(cell(change, form, glb)).symmetry();
            let name = (form, rotations, mirror, glb);
            assert_eq!(found.rotations, rotations, "{name:?}: {found:?}");
            assert_eq!(found.mirror_deg.is_some(), mirror, "{name:?}: {found:?}");
            tried += 1;
        }
        println!("{tried} cells");
        assert_eq!(tried, 11);
    }
}
