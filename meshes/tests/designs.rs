//! The designs: against their closed forms, and against the files that the repository carries.

use std::path::Path;

use glam::DVec3;
use meshes::design::{Design, Shape};
use meshes::{Cell, CellOptions, load_cell, normalise, write};

fn cell(design: Design) -> Cell {
    normalise(
        &design.mesh().expect("a legal design"),
        Path::new("design"),
        &CellOptions::default(),
    )
    .expect("a cell")
}

fn area(cell: &Cell) -> f64 {
    let p = &cell.entrance.polygon;
    (0..p.len())
        .map(|i| p[i].perp_dot(p[(i + 1) % p.len()]) / 2.0)
        .sum()
}

/// Dihedral angle less 90 degrees between two facets, from their unit normals: cos(90 + e) = -sin e of the outer angle.
fn error_between(a: [DVec3; 3], b: [DVec3; 3]) -> f64 {
    let normal = |t: [DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).normalize();
    // Inside normals at 90 deg + e enclose 90 deg - e.
    normal(a).dot(normal(b)).asin()
}

/// Rounding of a normalised coordinate: a few operations on numbers up to 2, 2.2e-16 each.
const ROUNDING: f64 = 4e-15;

#[test]
fn ideal_cells_have_their_closed_forms() {
    let root = 3f64.sqrt();
    // Height of the entrance, its area, facets: model of a cube corner with unit edges.
    let expected = [
        (Shape::Triangular, 1.0 / root, root / 2.0, 3),
        (Shape::TriangularPair, 1.0 / root, root, 6),
        (Shape::FullCube, 2.0 / root, root, 6),
    ];
    let mut cases = 0;
    for (shape, height, entrance_area, facets) in expected {
        for edge_length in [1e-6, 1.0, 3.0, 1e6] {
            let cell = cell(Design {
                edge_length,
                ..Design::new(shape)
            });
            assert_eq!(cell.facets.len(), facets);
            assert!((cell.entrance.height - height).abs() < ROUNDING);
            assert!((area(&cell) - entrance_area).abs() < ROUNDING);
            assert!((cell.edge_length / edge_length - 1.0).abs() < ROUNDING);
            assert_eq!(cell.entrance.lattice.is_some(), shape == Shape::FullCube);
            assert!(cell.warnings.is_empty() && !cell.closed);
            assert_eq!(cell.design, shape.name());
            assert!(cell.azimuth_zero.distance(DVec3::X) < ROUNDING);
            for facet in &cell.facets {
                // Counter-clockwise seen from the light: normals point up, each at 54.7 degrees from the sheet's.
                let normal = (facet[1] - facet[0]).cross(facet[2] - facet[0]).normalize();
                assert!((normal.z - 1.0 / root).abs() < ROUNDING);
            }
            // The first edge ends at azimuth 0.
            let end = cell.facets[0][1];
            assert!(end.distance(DVec3::new((2f64 / 3.0).sqrt(), 0.0, 1.0 / root)) < ROUNDING);
            cases += 1;
        }
    }
    assert_eq!(cases, 12);
}

#[test]
fn the_full_cube_tiles_by_its_lattice() {
    let cell = cell(Design::new(Shape::FullCube));
    let [a, b] = cell.entrance.lattice.expect("periodic");
    assert!(
        (a.length() - 2f64.sqrt()).abs() < ROUNDING && (b.length() - 2f64.sqrt()).abs() < ROUNDING
    );
    assert!((a.perp_dot(b) - 3f64.sqrt()).abs() < ROUNDING);
    // Every outer edge of the hexagon is an outer edge of a neighbour, at the same heights, run the other way.
    let outer: Vec<[DVec3; 2]> = cell.facets.iter().map(|f| [f[1], f[2]]).collect();
    let mut matched = 0;
    for [p, q] in &outer {
        for [r, s] in &outer {
            for (i, j) in [(1, 0), (0, 1), (1, 1), (-1, 0), (0, -1), (-1, -1)] {
                let shift = (a * f64::from(i) + b * f64::from(j)).extend(0.0);
                if p.distance(*s + shift) < ROUNDING && q.distance(*r + shift) < ROUNDING {
                    matched += 1;
                }
            }
        }
    }
    assert_eq!((outer.len(), matched), (6, 6));
}

/// The angle between facets is found to 1e-15: asin and two normals, near 0.
#[test]
fn dihedral_errors_arrive_in_the_cell() {
    let mut cases = 0;
    for shape in [
        Shape::Triangular,
        Shape::TriangularPair,
        Shape::FullCube,
        Shape::Canted,
    ] {
        for size in [1e-9, 1e-6, 1e-3, 1e-2, -1e-4] {
            for pattern in [
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [0.0, 0.0, 1.0],
                [1.0, 1.0, 1.0],
                [0.3, -0.7, 1.0],
            ] {
                let dihedral_error_rad = pattern.map(|p| p * size);
                let cell = cell(Design {
                    dihedral_error_rad,
                    ..Design::new(shape)
                });
                let step = if shape == Shape::FullCube { 2 } else { 1 };
                let facet = |k: usize| cell.facets[k % 3 * step];
                // Facets 1-2, 2-3 and 3-1 of the edges; edge 1 is shared by the facets 3-1 and 1-2.
                for (edge, planted) in dihedral_error_rad.into_iter().enumerate() {
                    let found = error_between(facet(edge + 2), facet(edge));
                    assert!((found - planted).abs() < 2e-15, "{shape:?} {found:e}");
                    cases += 1;
                }
            }
        }
    }
    assert_eq!(cases, 300);
}

#[test]
fn a_canted_cell_leans_by_its_angle() {
    let mut cases = 0;
    for cant_rad in [-0.6, -0.15, 0.0, 0.15, 0.5, 0.9] {
        let cell = cell(Design {
            cant_rad,
            ..Design::new(Shape::Canted)
        });
        let normals = [0, 1, 2].map(|k| {
            let f = cell.facets[k];
            (f[1] - f[0]).cross(f[2] - f[0]).normalize()
        });
        let axis = (normals[0] + normals[1] + normals[2]).normalize();
        // The sheet's normal leans towards edge 1 (azimuth 0), so the axis leans away from it.
        let expected = DVec3::new(-cant_rad.sin(), 0.0, cant_rad.cos());
        assert!(
            axis.distance(expected) < ROUNDING,
            "{cant_rad} {axis} {expected}"
        );
        let longest = cell.facets[..3]
            .iter()
            .map(|f| f[1].length())
            .fold(0.0, f64::max);
        assert!((longest - 1.0).abs() < ROUNDING);
        cases += 1;
    }
    assert_eq!(cases, 6);
}

#[test]
fn truncation_lowers_the_top_and_keeps_the_edge_length() {
    let mut cases = 0;
    for shape in Shape::ALL {
        let whole = cell(Design::new(shape));
        for truncation in [0.1, 0.25, 0.4] {
            let cell = cell(Design {
                truncation,
                ..Design::new(shape)
            });
            assert!(
                (cell.entrance.height - whole.entrance.height * (1.0 - truncation)).abs()
                    < ROUNDING
            );
            assert!((cell.edge_length - 3.0).abs() < ROUNDING);
            assert!(cell.warnings.is_empty(), "{:?}", cell.warnings);
            cases += 1;
        }
    }
    assert_eq!(cases, 12);
}

/// The files of the `designs` folder are what the code writes, and the folder's README has their hashes.
///
/// To make them anew after a wanted change: `UPDATE_DESIGNS=1 cargo test -p meshes --test designs`, and copy the hashes
/// that the test then prints.
#[test]
fn the_design_files_are_what_the_code_writes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("designs");
    let readme =
        std::fs::read_to_string(folder.join("README.md")).expect("the README of the designs");
    let fresh = tempfile::tempdir().expect("a temporary folder");
    let mut cases = 0;
    let mut missing = Vec::new();
    for shape in [Shape::Triangular, Shape::TriangularPair, Shape::FullCube] {
        for extension in ["obj", "glb"] {
            let name = format!("{}.{extension}", shape.name());
            let mesh = Design::new(shape).mesh().expect("a design");
            if std::env::var_os("UPDATE_DESIGNS").is_some() {
                write::save(&mesh, &folder.join(&name)).expect("a writable folder");
            }
            write::save(&mesh, &fresh.path().join(&name)).expect("a writable folder");
            let kept = std::fs::read(folder.join(&name)).expect("a design file");
            assert!(
                kept == std::fs::read(fresh.path().join(&name)).expect("a fresh file"),
                "{name} is out of date"
            );
            let found = load_cell(&folder.join(&name), &CellOptions::default()).expect("a cell");
            let row = format!(
                "| `{name}` | {} | {} | `{}` |",
                found.facets.len(),
                found.edge_length,
                found.mesh_hash
            );
            if !readme.contains(&row) {
                missing.push(row);
            }
            // Integers: f32 holds them as exactly as f64.
            assert_eq!(found.facets, cell(Design::new(shape)).facets, "{name}");
            cases += 1;
        }
    }
    assert!(
        missing.is_empty(),
        "not in designs/README.md:\n{}",
        missing.join("\n")
    );
    assert_eq!(cases, 6);
}
