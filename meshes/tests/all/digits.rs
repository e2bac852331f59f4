//! Coordinates with few digits: angles and rims that rounding has changed are said, with the digits
//! that are needed; angles that were meant are not.

use std::path::Path;

use glam::{DQuat, DVec3};
use meshes::design::{Design, Shape};
use meshes::{CellOptions, Mesh, normalise, obj, ply, stl, write};

/// Text of a mesh whose coordinates `number` writes.
fn text(mesh: &Mesh, number: impl Fn(f64) -> String) -> String {
    let vertices = mesh.positions.iter().map(|p| {
        let [x, y, z] = p.to_array().map(&number);
        format!("v {x} {y} {z}\n")
    });
    let faces = mesh.triangles.iter().map(|t| {
        let [a, b, c] = t.map(|vertex| vertex + 1);
        format!("f {a} {b} {c}\n")
    });
    vertices.chain(faces).collect()
}

/// Warnings about a mesh, or its fault.
fn said(mesh: &Mesh) -> Vec<String> {
    match normalise(mesh, Path::new("mesh"), &CellOptions::default()) {
        Ok(cell) => cell.warnings,
        Err(error) => vec![error.to_string()],
    }
}

/// Warnings about the mesh of a text, or its fault.
fn said_of(text: &str) -> Vec<String> {
    said(&obj::parse(text.as_bytes()).expect("an OBJ"))
}

/// Number of digits that a sentence asks for.
fn missing(sentence: &str) -> usize {
    let (_, after) = sentence.split_once("write the mesh with ").expect(sentence);
    let number = after.split(' ').next().expect("a word");
    number.parse().expect("a number of digits")
}

/// Mesh turned away from the axes of its file, with edges of `edge`.
fn turned(design: &Design, edge: f64) -> Mesh {
    let mesh = design.mesh().expect("a design");
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    let scale = edge / design.edge_length;
    let positions = mesh.positions.iter();
    Mesh {
        positions: positions.map(|&p| turn * p * scale).collect(),
        lattice: None,
        ..mesh
    }
}

/// Largest sine by which two faces of one cube miss a right angle: of cross products of the numbers
/// that the text holds.
fn off(text: &str) -> f64 {
    let mesh = obj::parse(text.as_bytes()).expect("an OBJ");
    let normals: Vec<DVec3> = (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            (b - a).cross(c - a).normalize()
        })
        .collect();
    let cubes = normals.chunks(3);
    let sines = cubes.flat_map(|n| [n[0].dot(n[1]), n[1].dot(n[2]), n[2].dot(n[0])]);
    sines.fold(0.0, |most: f64, sine| most.max(sine.abs()))
}

/// Ideal cubes in metres, with edges of 0.1 mm: whatever rounding has done to an angle above 5e-6
/// is said, nothing is said below, and the digits that the sentence asks for are enough.
#[test]
fn rounded_right_angles_and_rims_are_said() {
    let designs = [
        Design::new(Shape::Triangular),
        Design::new(Shape::TriangularPair),
        Design {
            cant_rad: 0.15,
            ..Design::new(Shape::Canted)
        },
    ];
    let (mut cases, mut bent, mut rims) = (0, 0, 0);
    for design in &designs {
        let mesh = turned(design, 1e-4);
        for fixed in [true, false] {
            // `%.6f` and its like, and six significant digits and their like.
            let write = |digits: usize| {
                text(&mesh, |x| match fixed {
                    true => format!("{x:.digits$}"),
                    false => format!(
                        "{:e}",
                        format!("{x:.*e}", digits - 4).parse::<f64>().unwrap()
                    ),
                })
            };
            for digits in 6..14 {
                let (text, name) = (write(digits), (design.shape, fixed, digits));
                let sentences = said_of(&text);
                let rim = sentences
                    .iter()
                    .any(|s| s.contains("the rim is not planar"));
                let expected = usize::from(rim || off(&text) > 5e-6);
                assert_eq!(sentences.len(), expected, "{name:?}: {sentences:?}");
                if let [one] = &sentences[..] {
                    assert!(missing(one) + digits < 14, "{name:?}: {one}");
                    let more = said_of(&write(digits + missing(one)));
                    assert!(more.is_empty(), "{name:?}: {one}, then {more:?}");
                }
                cases += 1;
                bent += usize::from(expected == 1 && !rim);
                rims += usize::from(rim);
            }
        }
    }
    println!("{cases} texts, {bent} with bent angles, {rims} with bent rims");
    assert_eq!(cases, 48);
    assert!(bent >= 10 && rims >= 5, "{bent} {rims}");
}

/// Pair of metres in six decimals, as a program wrote it. Its second cube lost half of its light
/// without a word.
const TRIAL: &str = "v 0.000000 0.000000 0.000000\nv 0.000074 0.000000 0.000000\n\
    v 0.000000 0.000100 0.000000\nv 0.000000 0.000000 0.000100\n\
    v 0.000003 0.000048 -0.000052\nv 0.000074 0.000100 -0.000100\n\
    f 1 2 3\nf 1 3 4\nf 1 4 2\nf 5 3 2\nf 5 2 6\nf 5 6 3\n";

/// An edge of 1e-4 in steps of 1e-6 is known to 5 mrad; 5e-6 rad need three digits more at least.
#[test]
fn a_mesh_in_metres_of_six_decimals_is_said() {
    let sentences = said_of(TRIAL);
    assert_eq!(sentences.len(), 1, "{sentences:?}");
    assert!((3..=5).contains(&missing(&sentences[0])), "{sentences:?}");

    // The same in STL, and in PLY behind another element and a number of more digits.
    let words = |key: &str| -> Vec<&str> {
        let lines = TRIAL.lines().filter_map(|line| line.strip_prefix(key));
        lines.map(str::trim).collect()
    };
    let (vertices, faces) = (words("v"), words("f"));
    let corners = |face: &str| -> Vec<usize> {
        let numbers = face.split(' ').map(|word| word.parse::<usize>());
        numbers
            .map(|number| number.expect("an index") - 1)
            .collect()
    };
    let facet = |face: &&str| {
        let corners = corners(face);
        let lines = corners.iter().map(|&k| format!("vertex {}\n", vertices[k]));
        let lines: String = lines.collect();
        format!("facet normal 0 0 0\nouter loop\n{lines}endloop\nendfacet\n")
    };
    let facets: String = faces.iter().map(facet).collect();
    let text = format!("solid\n{facets}endsolid\n");
    let stl = said(&stl::parse(text.as_bytes()).expect("an STL"));
    assert_eq!(stl, sentences);
    let mut body = String::from("1 2 3\n");
    vertices
        .iter()
        .for_each(|v| body += &format!("0.123456789 {v}\n"));
    for face in &faces {
        let numbers = corners(face).into_iter().map(|k| format!(" {k}"));
        body += &format!("3{}\n", numbers.collect::<String>());
    }
    for number in ["float", "double"] {
        let text = format!(
            "ply\nformat ascii 1.0\nelement camera 1\nproperty list uchar int at\n\
            property int up\nelement vertex 6\nproperty float quality\n\
            property {number} x\nproperty {number} y\nproperty {number} z\nelement face 6\n\
            property list uchar int vertex_indices\nend_header\n{body}"
        );
        let ply = said(&ply::parse(text.as_bytes()).expect("a PLY"));
        assert_eq!(ply, sentences, "{number}");
    }
}

/// Single precision far from the origin of a file is rounding too, and close to it is none that
/// light notices.
#[test]
fn single_precision_far_from_the_origin_is_said() {
    let design = Design {
        cant_rad: 0.15,
        ..Design::new(Shape::Canted)
    };
    for (far, expected) in [(0.0, 0), (1000.0, 1)] {
        let mut mesh = turned(&design, 0.1);
        mesh.positions.iter_mut().for_each(|p| p.x += far);
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("cell.glb");
        write::save(&mesh, &file).expect("writes");
        let sentences = said(&meshes::load(&file).expect("a mesh"));
        assert_eq!(sentences.len(), expected, "{far}: {sentences:?}");
        sentences.iter().for_each(|one| assert!(missing(one) > 0));
    }
}

/// Right prism, outward wound, that ends in a corner cube: three facets below a triangle, and
/// walls of `height` up to its front face.
fn walled(height: f64, edge: f64) -> Mesh {
    let mesh = turned(&Design::new(Shape::Triangular), edge);
    let [apex, a, b, c] = mesh.positions[..] else {
        panic!("four vertices");
    };
    let up = ((a + b + c) / 3.0 - apex).normalize() * height;
    let triangles = [
        [0, 2, 1],
        [0, 3, 2],
        [0, 1, 3],
        [1, 2, 5],
        [1, 5, 4],
        [2, 3, 6],
        [2, 6, 5],
        [3, 1, 4],
        [3, 4, 6],
        [4, 5, 6],
    ];
    Mesh {
        positions: vec![apex, a, b, c, a + up, b + up, c + up],
        triangles: triangles.to_vec(),
        ..Mesh::default()
    }
}

/// Angles that were meant, in coordinates that can tell them: dihedral errors, canted cubes, closed
/// solids with side walls, and the designs as they are written.
#[test]
fn meant_angles_with_enough_digits_are_no_warning() {
    let mut cases = 0;
    for shape in [Shape::Triangular, Shape::TriangularPair, Shape::Canted] {
        for error in [1e-5, 1e-4, 1e-3, 5e-2] {
            let design = Design {
                dihedral_error_rad: [error, 0.0, -0.6 * error],
                ..Design::new(shape)
            };
            for (edge, decimals) in [(0.1, 9), (1e-4, 12), (3.0, 8)] {
                let text = text(&turned(&design, edge), |x| format!("{x:.decimals$}"));
                let sentences = said_of(&text);
                assert!(sentences.is_empty(), "{shape:?} {error}: {sentences:?}");
                cases += 1;
            }
        }
    }
    for (edge, height, decimals) in [(10.0, 3.0, 7), (0.1, 0.05, 9)] {
        let text = text(&walled(height, edge), |x| format!("{x:.decimals$}"));
        let sentences = said_of(&text);
        // The walls themselves are named, and nothing is said of angles.
        let of_walls = |said: &String| said.contains("side walls");
        assert!(sentences.iter().all(of_walls), "{sentences:?}");
        let cell = normalise(
            &obj::parse(text.as_bytes()).expect("an OBJ"),
            Path::new("walls"),
            &CellOptions::default(),
        );
        let cell = cell.expect("a cell");
        assert!(cell.closed && cell.facets.len() == 9);
        cases += 1;
    }
    assert_eq!(cases, 38);
}
