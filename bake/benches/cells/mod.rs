//! The cells that are measured.
#![allow(dead_code, reason = "each benchmark takes what it needs")]

use bake::path::Rules;
use glam::{DVec2, DVec3};
use meshes::design::{Design, Shape};
use meshes::{Cell, CellOptions, Entrance};
use std::path::Path;

/// Mirrors behind a flat face of acrylic.
pub const RULES: Rules = Rules {
    refractive_index: 1.49,
    mirror_back: true,
    angular_tolerance_rad: 0.0087,
};

/// The ten directions of the default bake.
pub const INCIDENCE_DEG: [f64; 10] = [0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0];

/// Their azimuth, degrees.
pub const AZIMUTH_DEG: f64 = 30.0;

pub fn design(shape: Shape) -> Cell {
    let mesh = Design::new(shape).mesh().expect("a design");
    meshes::normalise(&mesh, Path::new("design"), &CellOptions::default()).expect("a cell")
}

/// 2,048 cubes: 32 x 32 pairs side by side, no two alike in their rounding.
pub fn sheet() -> Cell {
    let pair = design(Shape::TriangularPair);
    let side = 32;
    let [a, b, _, d] = pair.entrance.polygon[..] else {
        unreachable!("the entrance of a pair is a rhombus");
    };
    let (right, up) = (b - a, d - a);
    let places = (0..side * side).map(|k| right * f64::from(k % side) + up * f64::from(k / side));
    let facets = places
        .flat_map(|place: DVec2| {
            let moved = move |p: DVec3| p + place.extend(0.0);
            pair.facets.iter().map(move |facet| facet.map(moved))
        })
        .collect();
    let size = f64::from(side);
    let polygon = vec![a, a + right * size, a + (right + up) * size, a + up * size];
    Cell {
        facets,
        entrance: Entrance {
            polygon,
            ..pair.entrance
        },
        ..pair
    }
}
