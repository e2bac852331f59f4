//! The place and the size of a cell in its file do not matter, as far as the digits of the file go.

use crate::tests::hard_cases::both::{BothOptions, cell};
use glam::DVec3;
use meshes::design::{Design, Shape};
use meshes::{Cell, CellOptions, Mesh, load_cell, write};
use tables::Table;
use tables::options::Method;

const LIGHT: (&str, &str) = ("0,20,45", "0,30");

fn light() -> BothOptions {
    BothOptions::new(LIGHT.0, LIGHT.1).inside(1.49)
}

/// Writes `mesh` as OBJ and loads it again, as a user's file is loaded.
fn through_obj(mesh: &Mesh) -> Cell {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("cell.obj");
    std::fs::write(&file, write::obj(mesh)).expect("writes");
    load_cell(&file, &CellOptions::default()).expect("a cell")
}

fn worst_l1(a: &Table, b: &Table) -> f64 {
    tables::l1(a, b).into_iter().fold(0.0, f64::max)
}

/// Compares the moved cell with the cell of the design by both methods. Returns the L1 of the exact
/// tables and the L1 of the ray tables.
///
/// Both ray tables have equal samples. So they differ by the few rays that rounding takes over the
/// edge of a bin.
fn against_design(name: &str, moved: &Cell, shape: Shape) -> [f64; 2] {
    let here = light().on(name, moved);
    let design = cell(shape);
    [
        worst_l1(&here.exact, &light().bake(&design, Method::Exact)),
        worst_l1(&here.rays, &light().bake(&design, Method::Rays)),
    ]
}

/// Cells with edges of 1e-6 and 1e6 file units bake like the design.
///
/// Every vertex has three rounded coordinates (1.1e-16 of an edge each), and the frame turns by
/// about as much: 1e-15 in all. The outlines of the histogram's polygons, at most 12 long in all,
/// move by a few times that over an area of 3.5: L1 is below 1e-13. Of 200,000 rays none or one
/// crosses the edge of a bin (1e-15 x 64 bins x 200,000 is 1e-8).
#[test]
fn edges_of_a_millionth_and_of_a_million() {
    let mut cases = 0;
    for shape in Shape::ALL {
        for edge_length in [1e-6, 1e6] {
            let mesh = Design {
                edge_length,
                ..Design::new(shape)
            };
            let moved = through_obj(&mesh.mesh().expect("a design"));
            let [exact, rays] =
                against_design(&format!("{} {edge_length}", shape.name()), &moved, shape);
            let length = (moved.edge_length / edge_length - 1.0).abs();
            println!(
                "{}, edge {edge_length:e}: found to {length:.1e}, L1 {exact:.1e} exactly, \
                {rays:.1e} by rays",
                shape.name()
            );
            assert!(length < 1e-14 && exact < 1e-13, "{exact}");
            assert!(rays <= 2.0 / 200_000.0 * 1.001, "{rays}");
            cases += 1;
        }
    }
    assert_eq!(cases, 2 * Shape::ALL.len());
}

/// A cell in OBJ whose place is a million edges of 0.7 from the origin bakes like the design within
/// the rounding of the file.
///
/// A coordinate near 7e5 is rounded to 5.8e-11 file units, 8e-11 of an edge. So faces tilt by 4e-10
/// rad and outlines move by 1e-9: L1 goes up to 1e-8. 1e-9 x 64 bins x 200,000 rays means that none
/// or a few rays change bins.
#[test]
fn a_million_edges_away_in_obj() {
    let mut cases = 0;
    for shape in Shape::ALL {
        // The number 0.7 has no end in binary, so every coordinate is rounded anew where it lies.
        let design = Design {
            edge_length: 0.7,
            ..Design::new(shape)
        };
        let mesh = design.mesh().expect("a design");
        for offset in [
            DVec3::new(7e5, -7e5, 2e5),
            DVec3::new(7e5 + 0.123_456_789, 1.0 / 3.0, -4e5),
        ] {
            let positions = mesh.positions.iter().map(|&p| p + offset).collect();
            let moved = through_obj(&Mesh {
                positions,
                ..mesh.clone()
            });
            let name = format!("{} at {offset}", shape.name());
            let [exact, rays] = against_design(&name, &moved, shape);
            println!("{name}: L1 {exact:.1e} exactly, {rays:.1e} by rays");
            assert!(exact < 1e-8, "{name}: {exact}");
            assert!(rays <= 10.0 / 200_000.0, "{name}: {rays}");
            cases += 1;
        }
    }
    assert_eq!(cases, 2 * Shape::ALL.len());
}

/// A node translation in GLB of a million edges changes nothing: the local vertices are exact, and
/// so is the cell, whatever the node.
#[test]
fn a_million_edges_away_in_a_glb_node() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut cases = 0;
    for shape in [Shape::Triangular, Shape::TriangularPair, Shape::FullCube] {
        let mesh = Design::new(shape).mesh().expect("a design");
        let file = folder.path().join("far.glb");
        let translation = [3e6 + 0.123_456_789, -3e6, 1e6 / 3.0];
        std::fs::write(&file, glb(&mesh, translation)).expect("writes");
        let moved = load_cell(&file, &CellOptions::default()).expect("a cell");
        let [exact, rays] = against_design(shape.name(), &moved, shape);
        println!(
            "{} in a far node: L1 {exact:.1e} exactly, {rays:.1e} by rays",
            shape.name()
        );
        assert_eq!([exact, rays], [0.0, 0.0], "{}", shape.name());
        cases += 1;
    }
    assert_eq!(cases, 3);
}

/// Returns a binary glTF file of one node.
fn glb(mesh: &Mesh, translation: [f64; 3]) -> Vec<u8> {
    let positions = mesh.positions.iter().flat_map(|p| p.as_vec3().to_array());
    let mut bytes: Vec<u8> = positions.flat_map(f32::to_le_bytes).collect();
    let split = bytes.len();
    bytes.extend(
        mesh.triangles
            .iter()
            .flatten()
            .flat_map(|v| v.to_le_bytes()),
    );
    let lattice = mesh
        .lattice
        .map(|lattice| lattice.map(|v| v.to_array()).concat());
    let mut document = serde_json::json!({
        "asset": { "version": "2.0" },
        "extras": { "design": mesh.design },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "translation": translation }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "buffers": [{ "byteLength": bytes.len() }],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": split },
            { "buffer": 0, "byteOffset": split, "byteLength": bytes.len() - split },
        ],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "type": "VEC3",
                "count": mesh.positions.len(),
                "min": [0.0, 0.0, 0.0], "max": [6.0, 6.0, 6.0],
            },
            {
                "bufferView": 1, "componentType": 5125, "type": "SCALAR",
                "count": 3 * mesh.triangles.len(),
            },
        ],
    });
    if let Some(lattice) = lattice {
        document["extras"]["lattice"] = serde_json::json!(lattice);
    }
    // There are two chunks, each of a multiple of four bytes. The document is padded with blanks.
    // The buffer has numbers of four bytes and stays as it is.
    let mut document = document.to_string().into_bytes();
    document.resize(document.len().next_multiple_of(4), b' ');
    let word = |length: usize| u32::try_from(length).expect("a small file").to_le_bytes();
    let chunk = |kind: &[u8; 4], data: &[u8]| [&word(data.len()), &kind[..], data].concat();
    let chunks = [chunk(b"JSON", &document), chunk(b"BIN\0", &bytes)].concat();
    [&b"glTF"[..], &word(2), &word(12 + chunks.len()), &chunks].concat()
}
