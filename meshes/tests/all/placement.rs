//! A cell does not depend on position, size and order of its mesh in the file.

use glam::{DQuat, DVec3};
use meshes::design::{Design, Shape};
use meshes::{Cell, Mesh, obj, write};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

use crate::cells::{cell, same_facets};

/// Mesh with its vertices and triangles in another order, and with other first corners.
fn shuffled(mesh: &Mesh, seed: u64) -> Mesh {
    let mut state = seed | 1;
    let mut below = |n: usize| {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 33) as usize % n
    };
    let mut order: Vec<usize> = (0..mesh.positions.len()).collect();
    (1..order.len())
        .rev()
        .for_each(|i| order.swap(i, below(i + 1)));
    let mut place = vec![0_u32; order.len()];
    order
        .iter()
        .enumerate()
        .for_each(|(new, &old)| place[old] = new as u32);
    let mut triangles: Vec<[u32; 3]> = mesh
        .triangles
        .iter()
        .map(|t| t.map(|v| place[v as usize]))
        .collect();
    (1..triangles.len())
        .rev()
        .for_each(|i| triangles.swap(i, below(i + 1)));
    triangles.iter_mut().for_each(|t| t.rotate_left(below(3)));
    let positions = order.iter().map(|&old| mesh.positions[old]).collect();
    Mesh {
        positions,
        triangles,
        ..mesh.clone()
    }
}

fn placed(mesh: &Mesh, rotation: DQuat, scale: f64, offset: DVec3) -> Mesh {
    let positions = mesh
        .positions
        .iter()
        .map(|&p| rotation * p * scale + offset)
        .collect();
    let lattice = mesh.lattice.map(|l| l.map(|v| rotation * v * scale));
    Mesh {
        positions,
        lattice,
        edge_length: mesh.edge_length.map(|length| length * scale),
        ..mesh.clone()
    }
}

/// Largest distance between corresponding facet corners and entrance corners.
fn distance(a: &Cell, b: &Cell) -> f64 {
    assert_eq!(a.facets.len(), b.facets.len());
    assert_eq!(a.entrance.polygon.len(), b.entrance.polygon.len());
    let facets = a
        .facets
        .iter()
        .flatten()
        .zip(b.facets.iter().flatten())
        .map(|(p, q)| p.distance(*q));
    let entrance = a
        .entrance
        .polygon
        .iter()
        .zip(&b.entrance.polygon)
        .map(|(p, q)| p.distance(*q));
    facets
        .chain(entrance)
        .fold((a.entrance.height - b.entrance.height).abs(), f64::max)
}

/// Random rigid placement, scale 1e-6 to 1e6, offset up to 1e6 edge lengths, vertex order; dihedral
/// errors to 1e-2.
///
/// Tolerance: the test's own placement and the file round each coordinate to half a unit in the
/// last place, 1.1e-16 of the distance from the origin r (edge lengths), in 3 axes: 1.9e-16 r for a
/// vertex. A corner minus the apex has twice that error. The frame turns by the errors of its two
/// directions. Each is at most the error of 3 vertices over a lever of 0.7, seen at corners up to 2
/// away: at most 17 times the error of a vertex. Together this is under 20 * 1.9e-16 r = 3.8e-15 r,
/// plus 1e-14 for the arithmetic on numbers of order 1 (some forty operations).
#[test]
fn a_cell_does_not_depend_on_its_placement() {
    let mut runner = TestRunner::new_with_rng(
        Config {
            cases: 400,
            failure_persistence: None,
            ..Config::default()
        },
        proptest::test_runner::TestRng::deterministic_rng(
            proptest::test_runner::RngAlgorithm::ChaCha,
        ),
    );
    let inputs = (
        0..Shape::ALL.len(),
        prop::array::uniform4(-1.0..1.0_f64),
        -6.0..6.0_f64,
        (
            prop::array::uniform3(-1.0..1.0_f64),
            prop::option::of(0.0..6.0_f64),
        ),
        (any::<u64>(), prop::array::uniform3(-1e-2..1e-2_f64)),
    );
    let cases = std::cell::Cell::new(0);
    let worst = std::cell::Cell::new(0.0_f64);
    let far_worst = std::cell::Cell::new(0.0_f64);
    runner
        .run(
            &inputs,
            |(shape, quaternion, decade, (direction, far), (seed, dihedral_error_rad))| {
                prop_assume!(DQuat::from_array(quaternion).length() > 0.1);
                let mesh = Design {
                    dihedral_error_rad,
                    ..Design::new(Shape::ALL[shape])
                }
                .mesh()
                .expect("a design");
                let mesh = shuffled(&mesh, seed);
                let scale = 10_f64.powf(decade) / 3.0;
                let edges_away = far.map_or(0.0, |f| 10_f64.powf(f));
                let offset = DVec3::from_array(direction) * edges_away * 3.0 * scale;
                let moved = placed(
                    &mesh,
                    DQuat::from_array(quaternion).normalize(),
                    scale,
                    offset,
                );
                // The mesh also goes through the text, which must carry every digit.
                let read = obj::parse(write::obj(&moved).as_bytes()).expect("our own text");
                prop_assert_eq!(&read.positions, &moved.positions);
                let away = moved
                    .positions
                    .iter()
                    .map(|p| p.abs().max_element())
                    .fold(0.0, f64::max)
                    / (3.0 * scale);
                let tolerance = 3.8e-15 * away + 1e-14;
                let found = distance(&cell(&read), &cell(&mesh));
                worst.set(worst.get().max(found / tolerance));
                far_worst.set(far_worst.get().max(found));
                cases.set(cases.get() + 1);
                prop_assert!(
                    found <= tolerance,
                    "{:?} {} > {} at {}",
                    Shape::ALL[shape],
                    found,
                    tolerance,
                    away
                );
                Ok(())
            },
        )
        .unwrap_or_else(|error| panic!("{error}"));
    println!(
        "largest error {:.1e} edge lengths, {:.2} of the tolerance",
        far_worst.get(),
        worst.get()
    );
    assert_eq!(cases.get(), 400);
}

/// The ideal single cells look the same from each of their edges, so any first edge gives the same
/// facets. In the pair the shared edge turns with the choice, by a third of a turn.
#[test]
fn the_order_of_the_file_turns_an_ideal_cell_by_its_symmetry() {
    let mut cases = 0;
    for shape in [Shape::Triangular, Shape::TriangularPair, Shape::FullCube] {
        let mesh = Design::new(shape).mesh().expect("a design");
        let reference = cell(&mesh);
        for seed in 0..50 {
            let found = cell(&shuffled(&mesh, seed * 7919 + 3));
            let turns = if shape == Shape::TriangularPair { 3 } else { 1 };
            let same = (0..turns).any(|k| {
                let turn = DQuat::from_rotation_z(f64::from(k) * std::f64::consts::TAU / 3.0);
                let facets = found.facets.iter().map(|f| f.map(|p| turn * p)).collect();
                same_facets(
                    &Cell {
                        facets,
                        ..found.clone()
                    },
                    &reference,
                    4e-15,
                )
            });
            assert!(same, "{shape:?} {seed}");
            cases += 1;
        }
    }
    assert_eq!(cases, 150);
}

/// Two cubes that an f32 translation leaves 3e-8 of an edge apart are one cell, and nothing is
/// pulled together: the facets of the second cube are still exactly those of the first, turned.
#[test]
fn welding_moves_no_vertex() {
    let design = Design {
        dihedral_error_rad: [1e-9, -2e-9, 3e-9],
        ..Design::new(Shape::TriangularPair)
    };
    let joined = design.mesh().expect("a design");
    let gap = DVec3::new(9e-8, -5e-8, 7e-8);
    let mut apart = joined.clone();
    apart
        .positions
        .extend([1, 2].map(|v: usize| joined.positions[v] + gap));
    apart.positions[4] += gap;
    apart.positions[5] += gap;
    for triangle in &mut apart.triangles[3..] {
        *triangle = triangle.map(|v| if v < 4 { v + 5 } else { v });
    }
    let (joined, found) = (cell(&joined), cell(&apart));
    assert_eq!(found.entrance.polygon.len(), 4);
    assert!(found.warnings.is_empty());
    let mut cases = 0;
    for (facet, expected) in found.facets.iter().zip(&joined.facets) {
        for side in 0..3 {
            // Compare lengths of edge vectors, because the rim's tilt of up to 1e-7 turns both
            // cubes alike.
            let length = |f: &[DVec3; 3]| f[side].distance(f[(side + 1) % 3]);
            assert!((length(facet) - length(expected)).abs() < 1e-15);
            cases += 1;
        }
    }
    assert_eq!(cases, 18);
}

/// Contents of the design files, read back.
#[test]
fn files_read_back_what_was_written() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut cases = 0;
    for shape in Shape::ALL {
        for (truncation, refractive_index) in [(0.0, None), (0.25, Some(1.49))] {
            let design = Design {
                truncation,
                ..Design::new(shape)
            };
            let mesh = Mesh {
                refractive_index,
                ..design.mesh().expect("a design")
            };
            for extension in ["obj", "glb"] {
                let path = folder.path().join(format!("cell.{extension}"));
                write::save(&mesh, &path).expect("a writable folder");
                let read = meshes::load(&path).expect("our own file");
                // f32 holds a coordinate to 2^-24 of it, at most 3 * sqrt 2 here.
                let tolerance = if extension == "obj" {
                    0.0
                } else {
                    4.3 / f64::from(1 << 24)
                };
                let off = read
                    .positions
                    .iter()
                    .zip(&mesh.positions)
                    .map(|(p, q)| (*p - *q).abs().max_element());
                assert!(
                    off.fold(0.0, f64::max) <= tolerance,
                    "{shape:?} {extension}"
                );
                assert_eq!(
                    (&read.triangles, read.lattice),
                    (&mesh.triangles, mesh.lattice)
                );
                assert_eq!(
                    (&read.design, read.edge_length),
                    (&mesh.design, mesh.edge_length)
                );
                // OBJ has no place for an index.
                assert_eq!(
                    read.refractive_index,
                    refractive_index.filter(|_| extension == "glb")
                );
                if extension == "obj" {
                    assert_eq!(read.hash, mesh.hash);
                }
                // The frame doubles the error of an f32 corner; at most the errors of three corners
                // over a lever of 0.7 (see above): 17.
                let found = distance(&cell(&read), &cell(&mesh));
                assert!(found <= 17.0 * tolerance, "{shape:?} {extension} {found:e}");
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 4 * Shape::ALL.len());
    assert_eq!(
        std::fs::read_dir(folder.path())
            .expect("the folder")
            .count(),
        2,
        "a temporary file was left behind"
    );
}
