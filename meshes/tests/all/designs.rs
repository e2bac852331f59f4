//! Designs, compared with their closed forms and with the files in the repository.

use std::path::Path;

use glam::DVec3;
use meshes::design::{Design, Shape};
use meshes::{Cell, CellOptions, load_cell, write};

use crate::cells;

fn cell(design: Design) -> Cell {
    cells::cell(&design.mesh().expect("a legal design"))
}

fn area(cell: &Cell) -> f64 {
    let p = &cell.entrance.polygon;
    (0..p.len())
        .map(|i| p[i].perp_dot(p[(i + 1) % p.len()]) / 2.0)
        .sum()
}

/// Dihedral angle minus 90 degrees between two facets, from their unit normals: cos(90 + e) = -sin
/// e of the outer angle.
fn error_between(a: [DVec3; 3], b: [DVec3; 3]) -> f64 {
    let normal = |t: [DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).normalize();
    // Inside normals at 90 deg + e enclose 90 deg - e.
    normal(a).dot(normal(b)).asin()
}

/// Rounding of a normalised coordinate: a few operations on numbers up to 2, 2.2e-16 each.
const ROUNDING: f64 = 4e-15;

#[test]
fn ideal_cells_have_their_closed_forms() {
    let root = 3_f64.sqrt();
    // Height of the entrance, its area, and facets, for the model of a cube corner with unit edges.
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
                // Facets are counter-clockwise seen from the light: normals point up, each at 54.7
                // degrees from the sheet's normal.
                let normal = (facet[1] - facet[0]).cross(facet[2] - facet[0]).normalize();
                assert!((normal.z - 1.0 / root).abs() < ROUNDING);
            }
            // The first edge ends at azimuth 0.
            let end = cell.facets[0][1];
            assert!(end.distance(DVec3::new((2_f64 / 3.0).sqrt(), 0.0, 1.0 / root)) < ROUNDING);
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
        (a.length() - 2_f64.sqrt()).abs() < ROUNDING
            && (b.length() - 2_f64.sqrt()).abs() < ROUNDING
    );
    assert!((a.perp_dot(b) - 3_f64.sqrt()).abs() < ROUNDING);
    // Every outer edge of the hexagon is an outer edge of a neighbour, at the same heights, in the
    // opposite direction.
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

/// Tolerance: the angle between facets is found to 1e-15, from asin and two normals, near 0.
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
                // Facets 1-2, 2-3 and 3-1 of the edges. Edge 1 is shared by the facets 3-1 and 1-2.
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
    assert_eq!(cases, 3 * Shape::ALL.len());
}

/// The files of the `designs` folder are what the code writes, and the README of the folder has
/// their hashes.
///
/// To make them anew after an intended change, run `UPDATE_DESIGNS=1 cargo test -p meshes --test
/// all designs` and copy the hashes that the test then prints.
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
            // f32 holds integers as exactly as f64.
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

/// Worn cells and cells with land, read from OBJ and GLB like any file: one planar rim, no warning,
/// and the edge length and the first edge of the sharp cell.
#[test]
fn worn_cells_and_land_are_cells() {
    let mut cases = 0;
    for shape in [Shape::Triangular, Shape::TriangularPair, Shape::Canted] {
        let bent = [1e-3, 0.0, -2e-3];
        for (dihedral_error_rad, truncation) in [([0.0; 3], 0.0), (bent, 0.0), (bent, 0.2)] {
            let sharp = cell(Design {
                dihedral_error_rad,
                truncation,
                ..Design::new(shape)
            });
            for (edge_radius, strips, apex_flat, gap) in [
                (0.1, 1, 0.0, 0.0),
                (0.1, 8, 0.0, 0.0),
                (0.2, 3, 0.0, 0.4),
                (0.0, 8, 0.3, 0.0),
                (0.0, 8, 0.3, 0.1),
                (0.0, 8, 0.0, 0.2),
            ] {
                let mesh = Design {
                    dihedral_error_rad,
                    truncation,
                    edge_radius,
                    strips,
                    apex_flat,
                    gap,
                    ..Design::new(shape)
                }
                .mesh()
                .expect("a legal design");
                let cubes = if shape == Shape::Triangular { 1 } else { 2 };
                let facets = match (edge_radius > 0.0, apex_flat > 0.0) {
                    (true, _) => 3 + 6 * strips + strips * strips,
                    (_, true) => 7,
                    _ => 3,
                };
                let arcs = if edge_radius > 0.0 { 3 * strips } else { 0 };
                let land = if gap > 0.0 { 6 + arcs } else { 0 };
                // If the arcs of a pair differ, a side is split at their ends.
                let expected = cubes * (facets + land) as usize;
                assert!((expected..=expected + 4).contains(&mesh.triangles.len()));
                let folder = tempfile::tempdir().expect("a temporary folder");
                // Single precision rounds the rim by 1e-7 of its extent, more than it rounds the
                // rest.
                for (extension, rounding) in [("obj", 1e-13), ("glb", 3e-6)] {
                    let file = folder.path().join(format!("cell.{extension}"));
                    write::save(&mesh, &file).expect("a writable folder");
                    let found = load_cell(&file, &CellOptions::default()).expect("a cell");
                    assert!(found.warnings.is_empty(), "{:?}", found.warnings);
                    assert!((found.edge_length / sharp.edge_length - 1.0).abs() < rounding);
                    assert!(found.azimuth_zero.distance(sharp.azimuth_zero) < rounding);
                    // Each corner loses up to R^2 / 2 across the edge, over the cosine of its angle
                    // from the sheet's normal.
                    let (wide, own) = (area(&found), area(&sharp));
                    let cosine = sharp.entrance.height / (1.0 - truncation);
                    let off = 1.5 * cubes as f64 * (edge_radius / 3.0_f64).powi(2) / cosine;
                    // Bends of 2 mrad change angles by less than 1 %.
                    let off = 1.01 * off + own * rounding;
                    match gap > 0.0 {
                        true => assert!(wide > own),
                        false => assert!(wide <= own * (1.0 + rounding) && wide > own - off),
                    }
                }
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 3 * 3 * 6);
}

#[test]
fn worn_designs_are_refused_outside_their_range() {
    type Change = fn(&mut Design);
    let cases: [(Shape, Change, &str); 9] = [
        (
            Shape::Triangular,
            |d| d.edge_radius = 0.61,
            "0.61 is outside",
        ),
        (
            Shape::Triangular,
            |d| d.edge_radius = f64::NAN,
            "edge radius",
        ),
        (Shape::Triangular, |d| d.strips = 0, "number of strips of 0"),
        (Shape::TriangularPair, |d| d.apex_flat = 0.6, "apex of 0.6"),
        (Shape::Canted, |d| d.gap = -0.1, "gap of -0.1"),
        (
            Shape::FullCube,
            |d| d.edge_radius = 0.1,
            "take an edge radius",
        ),
        (Shape::FullCube, |d| d.apex_flat = 0.1, "take a flat apex"),
        (
            Shape::Canted,
            |d| (d.sag, d.gap) = (1e-3, 0.1),
            "a sag together",
        ),
        (
            Shape::Triangular,
            |d| (d.edge_radius, d.apex_flat) = (0.1, 0.1),
            "both an edge radius and a flat apex",
        ),
    ];
    for (shape, change, part) in cases {
        let mut design = Design::new(shape);
        change(&mut design);
        let fault = design.mesh().expect_err("out of range").to_string();
        assert!(fault.contains(part), "{fault}");
    }
}
