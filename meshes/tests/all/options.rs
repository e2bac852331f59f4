//! Options of the user take precedence over the file.

use glam::{DQuat, DVec3};
use meshes::design::Shape;
use meshes::{Cell, CellOptions, Mesh};

use crate::cells::{mesh, options, with};

/// Rounding of a few operations on numbers up to 2.
const ROUNDING: f64 = 4e-15;

fn cell(mesh: &Mesh, change: impl FnOnce(&mut CellOptions)) -> Cell {
    with(mesh, &options(change)).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn azimuth_zero_turns_the_cell_about_its_normal() {
    let mut cases = 0;
    for shape in Shape::ALL {
        let mesh = mesh(shape);
        let plain = cell(&mesh, |_| ());
        for degrees in [-170.0_f64, -60.0, 0.0, 15.0, 90.0, 120.0] {
            // A direction in the file that lies at this azimuth of the plain cell, and also out of
            // the sheet's plane. The frame of the plain cell in the file follows from its first
            // edge and the facets in both frames.
            let n = plain_normal(&mesh, &plain);
            let x = (plain.azimuth_zero - n * n.dot(plain.azimuth_zero)).normalize();
            let direction = DQuat::from_axis_angle(n, degrees.to_radians()) * x * 7.0 + n * 3.0;
            let turned = cell(&mesh, |o| o.azimuth_zero = Some(direction));
            assert!(turned.azimuth_zero.distance(direction.normalize()) < ROUNDING);
            let back = DQuat::from_rotation_z(-degrees.to_radians());
            for (found, expected) in turned
                .facets
                .iter()
                .flatten()
                .zip(plain.facets.iter().flatten())
            {
                assert!(
                    found.distance(back * *expected) < ROUNDING,
                    "{shape:?} {degrees}"
                );
            }
            assert!((turned.entrance.height - plain.entrance.height).abs() < ROUNDING);
            cases += 1;
        }
    }
    assert_eq!(cases, 6 * Shape::ALL.len());
}

/// Sheet's normal in the file, from two vertices of the first facet in both frames and the rotation
/// between them.
fn plain_normal(mesh: &Mesh, cell: &Cell) -> DVec3 {
    let [_, p, q] = mesh.corners(0).map(|p| p / cell.edge_length);
    let [_, u, v] = cell.facets[0];
    // z of the cell in the basis (u, v, u x v), carried to (p, q, p x q).
    let basis = glam::DMat3::from_cols(u, v, u.cross(v));
    let image = glam::DMat3::from_cols(p, q, p.cross(q));
    image * (basis.inverse() * DVec3::Z)
}

#[test]
fn edge_length_is_the_unit() {
    let mesh = Mesh {
        edge_length: Some(5.0),
        ..mesh(Shape::TriangularPair)
    };
    let stated = cell(&mesh, |_| ());
    assert_eq!(stated.edge_length, 5.0);
    let given = cell(&mesh, |o| o.edge_length = Some(6.0));
    assert_eq!(given.edge_length, 6.0);
    assert!((given.entrance.height - 0.5 / 3_f64.sqrt()).abs() < ROUNDING);
}

#[test]
fn any_basis_of_the_lattice_is_right_handed_and_covers_one_cell() {
    let mesh = mesh(Shape::FullCube);
    let [a, b] = mesh.lattice.expect("periodic");
    let mut cases = 0;
    for lattice in [
        [a, b],
        [b, a],
        [-a, b],
        [a, -b],
        [a + b, b],
        [a, b - a * 3.0],
    ] {
        let found = cell(&mesh, |o| o.lattice = Some(lattice));
        let [u, v] = found.entrance.lattice.expect("periodic");
        assert!((u.perp_dot(v) - 3_f64.sqrt()).abs() < ROUNDING);
        let p = &found.entrance.polygon;
        assert!((p[1] - p[0]).distance(u) < ROUNDING && (p[3] - p[0]).distance(v) < ROUNDING);
        let middle = (p[0] + p[1] + p[2] + p[3]) / 4.0;
        assert!(
            middle.length() < ROUNDING,
            "the hexagon lies around its apex"
        );
        assert!(found.warnings.is_empty());
        cases += 1;
    }
    assert_eq!(cases, 6);
}

/// Half of the cells of a sheet: the lattice is twice as long one way, which is allowed, with a
/// warning.
#[test]
fn gaps_between_cells_are_told() {
    let mesh = mesh(Shape::FullCube);
    let [a, b] = mesh.lattice.expect("periodic");
    let found = cell(&mesh, |o| o.lattice = Some([a * 2.0, b]));
    assert!(
        found.warnings.len() == 1 && found.warnings[0].contains("0.500000"),
        "{:?}",
        found.warnings
    );
}

#[test]
fn an_inverted_periodic_cell_is_turned_over() {
    let mut mesh = mesh(Shape::FullCube);
    let plain = cell(&mesh, |_| ());
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let found = cell(&mesh, |_| ());
    assert_eq!(
        (found.facets, found.entrance),
        (plain.facets, plain.entrance)
    );
    assert!(found.warnings.len() == 1 && found.warnings[0].contains("turned over"));
}

/// A slip or a wrong unit in the edge length is told. An edge that is a few per cent off is the
/// user's unit.
#[test]
fn another_edge_length_than_that_of_the_mesh_is_told() {
    let measured = mesh(Shape::TriangularPair);
    let own = cell(&measured, |_| ()).edge_length;
    let stated = Mesh {
        edge_length: Some(own),
        ..measured.clone()
    };
    let mut cases = 0;
    for mesh in [&stated, &measured] {
        for (factor, told) in [
            (1.0, false),
            (0.95, false),
            (1.05, false),
            (0.5, true),
            (0.001, true),
            (1.2, true),
        ] {
            let edge_length = factor * own;
            let warnings = cell(mesh, |o| o.edge_length = Some(edge_length)).warnings;
            let warned = |text: &String| text.contains(&format!("--edge-length is {edge_length},"));
            assert_eq!(
                warnings.iter().any(warned),
                told,
                "{edge_length}: {warnings:?}"
            );
            assert_eq!(warnings.len(), usize::from(told), "{warnings:?}");
            cases += 1;
        }
    }
    assert_eq!(cases, 12);
}
