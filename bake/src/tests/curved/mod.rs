//! Curved faces: facets with interpolated normals against the curved face itself, refusals and
//! warnings.

pub(crate) mod convergence;
pub(crate) mod oracle;
pub(crate) mod rules;

use crate::optics::Rules;
use crate::tests::cells::of_mesh;
use meshes::design::{Design, Shape};
use meshes::{Cell, Mesh};

/// Rules of mirrors in air. Light that is bent by up to 10 degrees still counts as retroreflected.
const RULES: Rules = Rules {
    angular_tolerance_rad: 0.174,
    ..Rules::mirrors(1.0)
};

fn design(shape: Shape, sag: f64, segments: u32) -> Mesh {
    let design = Design {
        sag,
        segments,
        ..Design::new(shape)
    };
    design.mesh().expect("a design")
}

/// Returns the cell of `mesh`. Its facets have the normals of the mesh, or are planes.
fn cell(mesh: &Mesh, file_normals: bool) -> Cell {
    of_mesh(mesh, |options| options.file_normals = file_normals)
}
