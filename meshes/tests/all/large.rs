//! Meshes of many cubes, and cubes of many triangles.

use std::time::Instant;

use glam::DVec3;
use meshes::design::{Design, Shape};
use meshes::{CellOptions, Mesh};

use crate::cells::{cell, options, with};

/// Sheet of `across` x `across` pairs side by side, each with vertices of its own.
fn patch(across: u32) -> Mesh {
    let pair = Design::new(Shape::TriangularPair).mesh().expect("a design");
    // The rhombus has the corners 1, 6, 2, 3 (by number). Its sides are the lattice.
    let [a, b] = [
        pair.positions[5] - pair.positions[1],
        pair.positions[3] - pair.positions[1],
    ];
    let mut mesh = Mesh {
        design: "patch".to_owned(),
        ..Mesh::default()
    };
    for row in 0..across {
        for column in 0..across {
            let first = mesh.positions.len() as u32;
            let offset = a * f64::from(column) + b * f64::from(row);
            mesh.positions
                .extend(pair.positions.iter().map(|p| *p + offset));
            mesh.triangles
                .extend(pair.triangles.iter().map(|t| t.map(|v| v + first)));
        }
    }
    mesh
}

#[test]
fn a_patch_of_two_thousand_cubes_normalises() {
    let across = 32;
    let mesh = patch(across);
    let start = Instant::now();
    let cell = cell(&mesh);
    println!(
        "{} cubes in {:.1} ms",
        2 * across * across,
        start.elapsed().as_secs_f64() * 1e3
    );
    assert_eq!(cell.facets.len(), 6 * 1024);
    assert!((cell.edge_length - 3.0).abs() < 1e-14);
    // Only four corners are left, without the points along the sides. The area of a pair is sqrt 3.
    let p = &cell.entrance.polygon;
    assert_eq!(p.len(), 4);
    let area: f64 = (0..4).map(|i| p[i].perp_dot(p[(i + 1) % 4]) / 2.0).sum();
    // Coordinates go to 91 edge lengths, rounded to 1e-14, over a rim of 181.
    assert!((area - 1024.0 * 3_f64.sqrt()).abs() < 4e-12, "{area}");
    assert!(cell.warnings.is_empty());
}

/// Every triangle is cut into `parts` x `parts`, with vertices of its own; `bend` moves a point of
/// the surface.
fn refined(mesh: &Mesh, parts: u32, bend: impl Fn(DVec3) -> DVec3) -> Mesh {
    let mut fine = Mesh {
        positions: Vec::new(),
        triangles: Vec::new(),
        ..mesh.clone()
    };
    for triangle in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(triangle);
        let at = |i: u32, j: u32| {
            let (u, v) = (
                f64::from(i) / f64::from(parts),
                f64::from(j) / f64::from(parts),
            );
            // Weighted sums from the two sides of an edge differ by rounding, which welding must
            // bridge.
            bend(a * (1.0 - u - v) + b * u + c * v)
        };
        for j in 0..parts {
            for i in 0..parts - j {
                let mut push = |corners: [DVec3; 3]| {
                    let first = fine.positions.len() as u32;
                    fine.positions.extend(corners);
                    fine.triangles.push([first, first + 1, first + 2]);
                };
                push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 1 < parts {
                    push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    fine
}

#[test]
fn finely_triangulated_facets_keep_their_apex() {
    let mut cases = 0;
    for (shape, parts) in [
        (Shape::Triangular, 200),
        (Shape::TriangularPair, 40),
        (Shape::FullCube, 40),
    ] {
        let mesh = Design::new(shape).mesh().expect("a design");
        let coarse = cell(&mesh);
        let fine = refined(&mesh, parts, |p| p);
        let start = Instant::now();
        let found = cell(&fine);
        println!(
            "{} triangles in {:.0} ms",
            fine.triangles.len(),
            start.elapsed().as_secs_f64() * 1e3
        );
        // The first leg in the file is that of the first facet, so the frames are equal.
        assert!((found.edge_length - 3.0).abs() < 1e-14);
        assert!(
            (found.entrance.height - coarse.entrance.height).abs() < 1e-14,
            "{:e}",
            found.entrance.height - coarse.entrance.height
        );
        assert!(
            found.azimuth_zero.distance(coarse.azimuth_zero) < 1e-14,
            "{shape:?} {}",
            found.azimuth_zero
        );
        assert_eq!(
            found.facets.len(),
            mesh.triangles.len() * (parts * parts) as usize
        );
        cases += 1;
    }
    assert_eq!(cases, 3);
}

/// Facets that bulge by a hundredth of an edge, with straight edges: the apex and the edges are
/// still found.
#[test]
fn slightly_curved_facets_keep_their_apex() {
    let mesh = Design::new(Shape::Triangular).mesh().expect("a design");
    let bulge = |p: DVec3| {
        let [x, y, z] = p.to_array().map(|c| c.max(0.0));
        // The bulge is zero on the edges and on the rim, so that both stay in place.
        let rise = 0.01 * (1.0 - (x + y + z) / 3.0).max(0.0);
        p + DVec3::new(y * z, z * x, x * y) * rise
    };
    let found = cell(&refined(&mesh, 60, bulge));
    assert!((found.edge_length - 3.0).abs() < 1e-14);
    assert!(found.azimuth_zero.distance(DVec3::X) < 1e-14);
    assert_eq!(found.facets.len(), 3 * 3600);
}

/// A bowl has no apex. It is refused, unless the user gives an edge length and an azimuth zero.
#[test]
fn a_cell_without_an_apex_needs_options() {
    let positions = vec![DVec3::ZERO, DVec3::X * 3.0, DVec3::Y * 3.0];
    let flat = Mesh {
        positions,
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    // The bowl is zero on the rim, and lowest in the middle, (1, 1): 0.2.
    let fine = refined(&flat, 21, |p| {
        p - DVec3::Z * (0.2 * p.x * p.y * (3.0 - p.x - p.y))
    });
    let none = with(&fine, &CellOptions::default());
    assert!(
        none.as_ref()
            .is_err_and(|e| e.to_string().contains("--edge-length")),
        "{none:?}"
    );
    let half = with(&fine, &options(|o| o.edge_length = Some(2.0)));
    assert!(half.is_err_and(|e| e.to_string().contains("--azimuth-zero")));
    let azimuth_zero = Some(DVec3::new(1.0, -1.0, 0.0));
    let both = options(|o| (o.edge_length, o.azimuth_zero) = (Some(2.0), azimuth_zero));
    let found = with(&fine, &both).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((found.edge_length, found.entrance.polygon.len()), (2.0, 3));
    assert!((found.entrance.height - 0.1).abs() < 1e-15);
    let lowest = found
        .facets
        .iter()
        .flatten()
        .map(|p| p.z)
        .fold(f64::INFINITY, f64::min);
    assert_eq!(lowest, 0.0);
}
