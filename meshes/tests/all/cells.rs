//! Cells of meshes in memory, and meshes of designs.

use std::path::Path;

use meshes::design::{Design, Shape};
use meshes::{Cell, CellOptions, Error, Mesh, normalise};

/// Makes the cell of a mesh with these options.
pub(crate) fn with(mesh: &Mesh, options: &CellOptions) -> Result<Cell, Error> {
    normalise(mesh, Path::new("mesh.obj"), options)
}

/// Makes the cell of a mesh without options.
#[track_caller]
pub(crate) fn cell(mesh: &Mesh) -> Cell {
    with(mesh, &CellOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

pub(crate) fn mesh(shape: Shape) -> Mesh {
    Design::new(shape).mesh().expect("a design")
}

/// Returns options with one change.
pub(crate) fn options(change: impl FnOnce(&mut CellOptions)) -> CellOptions {
    let mut options = CellOptions::default();
    change(&mut options);
    options
}

/// Compares the facets of two cells as sets of vertex sets; file order and first corners do not
/// matter.
pub(crate) fn same_facets(a: &Cell, b: &Cell, tolerance: f64) -> bool {
    let near = |f: &[glam::DVec3; 3], g: &[glam::DVec3; 3]| {
        (0..3).any(|k| (0..3).all(|i| f[i].distance(g[(i + k) % 3]) <= tolerance))
    };
    a.facets.len() == b.facets.len() && a.facets.iter().all(|f| b.facets.iter().any(|g| near(f, g)))
}
