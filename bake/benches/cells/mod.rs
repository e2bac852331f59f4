//! The cells that are measured.
#![allow(dead_code, reason = "each benchmark takes what it needs")]

use bake::rays::path::Rules;
use meshes::design::{Design, Shape};
use meshes::{Cell, CellOptions, Mesh};
use std::path::Path;

/// Mirrors behind a flat face of acrylic.
pub const RULES: Rules = Rules::mirrors(1.49);

/// The ten directions of the default bake.
pub const INCIDENCE_DEG: [f64; 10] = [0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0];

/// Their azimuth, degrees.
pub const AZIMUTH_DEG: f64 = 30.0;

pub fn design(shape: Shape) -> Cell {
    cell(&Design::new(shape).mesh().expect("a design"))
}

/// 2,048 cubes: 32 x 32 pairs side by side. All coordinates are whole file units, so that neighbours share vertices.
pub fn sheet() -> Cell {
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

fn cell(mesh: &Mesh) -> Cell {
    meshes::normalise(mesh, Path::new("mesh"), &CellOptions::default()).expect("a cell")
}
