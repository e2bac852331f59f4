//! Cells that are measured, and bakes of them on one thread.
#![allow(dead_code, reason = "each benchmark takes what it needs")]

use bake::{Plan, Prepared, Progress, Request, trace};
use meshes::design::{Design, Shape};
use meshes::{Cell, CellOptions, Mesh};
use std::path::Path;
use tables::Table;

/// Requests the ten directions of the default bake on one thread.
///
/// The cubes have mirrors behind a flat face of acrylic.
pub(crate) fn request() -> Request {
    Request {
        incidence: "0:45:5".into(),
        azimuth: "30".into(),
        refractive_index: Some(1.49),
        threads: Some(1),
        ..Request::default()
    }
}

/// Bakes the table of a dissected cell.
pub(crate) fn bake(cell: &Prepared, request: &Request) -> Table {
    let plan = Plan::new(request).expect("a valid request");
    trace(cell, &plan, Progress::none()).expect("bakes")
}

pub(crate) fn design(shape: Shape) -> Cell {
    cell(&Design::new(shape).mesh().expect("a design"))
}

/// Returns a sheet of 2,048 cubes: 32 x 32 pairs side by side.
///
/// All coordinates are whole file units, so that neighbours share vertices.
pub(crate) fn sheet() -> Cell {
    let pair = Design::new(Shape::TriangularPair).mesh().expect("a design");
    let [_, a, b, c, ..] = pair.positions[..] else {
        unreachable!("a pair has an apex and three edge ends first");
    };
    let (right, up) = (a - c, b - c);
    let mut mesh = Mesh {
        positions: Vec::new(),
        triangles: Vec::new(),
        ..pair.clone()
    };
    for (i, j) in (0..32).flat_map(|i| (0..32).map(move |j| (i, j))) {
        let place = right * f64::from(i) + up * f64::from(j);
        let first = mesh.positions.len() as u32;
        mesh.positions
            .extend(pair.positions.iter().map(|&p| p + place));
        mesh.triangles
            .extend(pair.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    cell(&mesh)
}

/// Makes the cell of a mesh in memory.
pub(crate) fn cell(mesh: &Mesh) -> Cell {
    meshes::normalise(mesh, Path::new("mesh"), &CellOptions::default()).expect("a cell")
}
