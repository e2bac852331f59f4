//! Files that users might hand over: bad ones with the message that each must get, good ones with
//! their cell.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use glam::DVec3;
use meshes::design::{Design, Shape};
use meshes::{Cell, CellOptions, gltf, load_cell, normalise, obj};
use serde_json::{Value, json};

use crate::cells::{cell, mesh, options, same_facets};

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests")
        .join(name)
}

#[test]
fn every_bad_file_gets_its_message() {
    let text = std::fs::read_to_string(folder("bad/expected.toml")).expect("the table of messages");
    let expected: BTreeMap<String, Vec<String>> = toml::from_str(&text).expect("a table of lists");
    let listed = std::fs::read_dir(folder("bad")).expect("a folder").count() - 1;
    assert_eq!(
        listed,
        expected.len(),
        "a file without a message, or a message without a file"
    );
    let mut cases = 0;
    let mut wrong = Vec::new();
    for (file, parts) in &expected {
        let path = folder("bad").join(file);
        assert!(path.exists() && !parts.is_empty(), "{file}");
        cases += 1;
        match load_cell(&path, &CellOptions::default()) {
            Ok(_) => wrong.push(format!("{file}: accepted")),
            Err(error) => {
                let message = error.to_string();
                let named =
                    message.starts_with(&path.display().to_string()) && !message.contains('\n');
                if !named || !parts.iter().all(|part| message.contains(part.as_str())) {
                    wrong.push(format!("{file}: {message}, expected {parts:?}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert_eq!(cases, 100);
}

/// A pipe is not waited for, and a link does not lead out of the folder of the mesh.
#[test]
fn pipes_and_links_out_of_the_folder_are_refused() {
    let whole = tempfile::tempdir().expect("a temporary folder");
    let inner = whole.path().join("inner");
    std::fs::create_dir(&inner).expect("a folder");
    let said = |path: &Path| match load_cell(path, &CellOptions::default()) {
        Ok(_) => "accepted".to_owned(),
        Err(error) => error.to_string(),
    };
    let pipe = |name: &str| {
        let path = inner.join(name);
        let made = std::process::Command::new("mkfifo").arg(&path).status();
        assert!(made.expect("mkfifo").success());
        path
    };
    let mesh = pipe("pipe.obj");
    assert!(
        said(&mesh).contains("is no regular file"),
        "{}",
        said(&mesh)
    );
    let gltf = inner.join("external.gltf");
    std::fs::copy(folder("good/external.gltf"), &gltf).expect("a copy");
    let buffer = inner.join("external buffer.bin");
    // The buffer itself, a link to it elsewhere, a pipe, and a link within the folder.
    let good = folder("good/external buffer.bin");
    std::fs::copy(&good, &buffer).expect("a copy");
    assert_eq!(said(&gltf), "accepted");
    std::fs::remove_file(&buffer).expect("a file");
    let outside = whole.path().join("secret");
    std::fs::copy(&good, &outside).expect("a copy");
    std::os::unix::fs::symlink(&outside, &buffer).expect("a link");
    assert!(
        said(&gltf).contains("it leaves the folder"),
        "{}",
        said(&gltf)
    );
    std::fs::remove_file(&buffer).expect("a file");
    pipe("external buffer.bin");
    assert!(
        said(&gltf).contains("it is no regular file"),
        "{}",
        said(&gltf)
    );
    std::fs::remove_file(&buffer).expect("a file");
    std::fs::copy(&good, inner.join("beside")).expect("a copy");
    std::os::unix::fs::symlink(inner.join("beside"), &buffer).expect("a link");
    assert_eq!(said(&gltf), "accepted");
}

#[test]
fn a_missing_file_and_bad_options_are_told() {
    let missing = load_cell(&folder("bad/there_is_none.obj"), &CellOptions::default());
    assert!(
        missing
            .expect_err("no such file")
            .to_string()
            .contains("cannot be read")
    );
    type Change = fn(&mut CellOptions);
    let cases: [(Change, &str); 6] = [
        (|o| o.edge_length = Some(0.0), "edge length 0 is not usable"),
        (|o| o.edge_length = Some(-1.0), "edge length -1 is not"),
        (|o| o.edge_length = Some(f64::NAN), "edge length NaN is"),
        (|o| o.azimuth_zero = Some(DVec3::ONE), "1,1,1 has no"),
        (|o| o.azimuth_zero = Some(DVec3::ZERO), "0,0,0 has no"),
        (|o| o.lattice = Some([DVec3::X, DVec3::Y]), "off the plane"),
    ];
    for (change, part) in cases {
        let message = load_cell(&folder("good/binary.glb"), &options(change))
            .expect_err("a bad option")
            .to_string();
        assert!(message.contains(part), "{message}");
    }
}

/// A mesh that says that it is hollow has the index 1, in both formats, and is written so again. A
/// comment that only begins with the word says nothing.
#[test]
fn a_mesh_can_say_that_it_is_hollow() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let design = Design::new(Shape::TriangularPair);
    let mut cases = 0;
    for hollow in [false, true] {
        let mesh = meshes::Mesh {
            hollow,
            ..design.mesh().expect("a design")
        };
        for name in ["cell.obj", "cell.glb"] {
            let path = folder.path().join(name);
            meshes::write::save(&mesh, &path).expect("writes");
            assert_eq!(
                meshes::load(&path).expect("a mesh").hollow,
                hollow,
                "{name}"
            );
            let cell = load_cell(&path, &CellOptions::default()).expect("a cell");
            assert_eq!(cell.refractive_index, hollow.then_some(1.0), "{name}");
            cases += 1;
        }
    }
    assert_eq!(cases, 4);
    let path = folder.path().join("cell.obj");
    let text = std::fs::read_to_string(&path).expect("an OBJ");
    assert!(text.contains("\n# hollow\n"), "{text}");
    std::fs::write(&path, text.replace("# hollow", "# hollow cubes of nickel")).expect("writes");
    let cell = load_cell(&path, &CellOptions::default()).expect("a cell");
    assert_eq!(cell.refractive_index, None);
}

#[test]
fn every_good_file_is_its_cell() {
    let design = |shape| cell(&mesh(shape));
    let (single, pair, full) = (
        design(Shape::Triangular),
        design(Shape::TriangularPair),
        design(Shape::FullCube),
    );
    // Columns: file, cell, edge length, warnings, closed. Coordinates are exact f32 or decimal, so
    // only rounding is left, 4e-15 (a few operations on numbers up to 2). The second node of the
    // pair has an f32 quaternion with three equal entries, exact once renormalised.
    // Integers of 16 bits are exact; only the scale of their node is an f32.
    let quantized = 3.0 * f64::from(3.2767_f32) / 3.2767;
    let cases: [(&str, &Cell, f64, usize, bool); 29] = [
        ("byte_order_mark.obj", &full, 3.0, 0, false),
        // Written by numpy-stl, trimesh and plyfile, and one as CAD programs head their binary
        // files.
        ("ascii.stl", &pair, 3.0, 0, false),
        ("binary.stl", &pair, 3.0, 0, false),
        ("solid_header.stl", &pair, 3.0, 0, false),
        ("ascii.ply", &full, 3.0, 0, false),
        ("big_endian.ply", &full, 3.0, 0, false),
        ("single.ply", &pair, 3.0, 0, false),
        ("quantized.glb", &pair, quantized, 0, false),
        ("quads.obj", &full, 3.0, 0, false),
        ("negative_indices.obj", &single, 3.0, 0, false),
        ("millimetres.obj", &single, 0.05, 0, false),
        ("vertex_per_face.obj", &single, 3.0, 0, false),
        ("continued_lines.obj", &single, 3.0, 0, false),
        ("weighted_vertices.obj", &single, 3.0, 0, false),
        ("inverted.obj", &single, 3.0, 1, false),
        ("pair.obj", &pair, 3.0, 0, false),
        ("prism.obj", &single, 3.0, 0, true),
        ("prism_inverted.obj", &single, 3.0, 1, true),
        ("prism_with_index.gltf", &single, 3.0, 0, true),
        ("embedded.gltf", &single, 3.0, 0, false),
        ("external.gltf", &single, 3.0, 0, false),
        ("far_node.gltf", &single, 6.0, 0, false),
        ("mirrored_node.gltf", &single, 3.0, 0, false),
        ("matrix_node.gltf", &single, 6.0, 0, false),
        ("pair_of_nodes.gltf", &pair, 3.0, 0, false),
        ("fan.gltf", &single, 3.0, 0, false),
        ("byte_indices.gltf", &single, 3.0, 0, false),
        ("binary.glb", &single, 3.0, 0, false),
        ("concave_polygon.obj", &single, 3.0, 0, false),
    ];
    for (file, expected, edge_length, warnings, closed) in &cases {
        let cell = load_cell(&folder("good").join(file), &CellOptions::default())
            .unwrap_or_else(|e| panic!("{e}"));
        assert!(
            (cell.edge_length / edge_length - 1.0).abs() < 4e-15,
            "{file}: {}",
            cell.edge_length
        );
        assert!(
            (cell.entrance.height - expected.entrance.height).abs() < 4e-15,
            "{file}"
        );
        assert_eq!(
            cell.entrance.polygon.len(),
            expected.entrance.polygon.len(),
            "{file}"
        );
        assert_eq!(
            (cell.warnings.len(), cell.closed),
            (*warnings, *closed),
            "{file}: {:?}",
            cell.warnings
        );
        assert_eq!(
            cell.refractive_index,
            file.contains("index.gltf").then_some(1.49),
            "{file}"
        );
        assert_eq!(cell.mesh_hash.len(), 64, "{file}");
        if *file == "concave_polygon.obj" {
            let area: f64 = cell
                .facets
                .iter()
                .map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0)
                .sum();
            assert!(
                (area - 1.5).abs() < 4e-15 && cell.facets.len() == 5,
                "{file}: {area}"
            );
        } else {
            assert!(
                same_facets(&cell, expected, 4e-15),
                "{file}: {:?}",
                cell.facets
            );
        }
    }
    // A buffer, and a cell with a cant and dihedral errors.
    let others = 2;
    assert_eq!(
        std::fs::read_dir(folder("good")).expect("a folder").count(),
        cases.len() + others
    );
}

/// Marks, line ends and comments that other programs write change no mesh but its hash: every good
/// OBJ with a byte order mark, with the line ends of Windows and of old Macs, and with comments
/// behind its vertices, normals and faces.
#[test]
fn marks_line_ends_and_comments_change_nothing() {
    let mut cases = 0;
    for entry in std::fs::read_dir(folder("good")).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|e| e != "obj") {
            continue;
        }
        let bytes = std::fs::read(&path).expect("a file");
        let text = String::from_utf8_lossy(&bytes);
        let text = text.trim_start_matches('\u{feff}');
        let lines: Vec<String> = text
            .lines()
            .map(
                |line| match line.starts_with(['v', 'f']) && !line.ends_with('\\') {
                    true => format!("{line} # 1 2 C:\\"),
                    false => line.to_owned(),
                },
            )
            .collect();
        let parsed = |text: &str| meshes::Mesh {
            hash: String::new(),
            ..obj::parse(text.as_bytes()).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
        };
        let plain = parsed(text);
        for other in [
            format!("\u{feff}{text}"),
            text.replace('\n', "\r\n"),
            text.replace('\n', "\r"),
            lines.join("\n"),
        ] {
            assert_eq!(parsed(&other), plain, "{}", path.display());
            cases += 1;
        }
    }
    assert_eq!(cases, 4 * 12);
}

/// A sparse accessor gives the positions that replace its own: those of the mesh from which it was
/// made, in single precision. Without a view all other positions are 0.
#[test]
fn sparse_positions_are_read() {
    let expected = [
        [0.0; 3],
        [2.207458173, 0.00033116, -0.000110497],
        [0.000449992, 2.999568927, -0.000749926],
        [-0.000150169, -0.000750034, 2.999999902],
        [0.088833133, 1.440232692, -1.560727693],
        [2.208058333, 3.000650121, -3.000860326],
    ];
    let mesh = meshes::load(&folder("good/sparse.glb")).expect("a mesh");
    assert_eq!(mesh.positions.len(), expected.len());
    // f32 keeps 6e-8 of each number.
    let near = |p: &DVec3, q: [f64; 3]| p.abs_diff_eq(q.into(), 3e-7);
    let mut pairs = mesh.positions.iter().zip(expected);
    assert!(pairs.all(|(p, q)| near(p, q)), "{:?}", mesh.positions);
    load_cell(&folder("good/sparse.glb"), &CellOptions::default()).expect("a cell");

    // Without a view: the outer corners of the single cube, all else 0. A sparse index beyond the
    // positions is refused.
    let single = load_cell(&folder("good/embedded.gltf"), &CellOptions::default()).expect("a cell");
    for (last, read) in [(3, true), (4, false)] {
        let mesh = gltf::parse(
            &document(|json, buffer| {
                let at = buffer.len();
                buffer.extend([1, 2, last]);
                let views = json["bufferViews"].as_array_mut().expect("views");
                views.push(json!({ "buffer": 0, "byteOffset": at, "byteLength": 3 }));
                let positions = json["accessors"][0].as_object_mut().expect("an accessor");
                positions.remove("bufferView");
                let sparse = json!({
                    "count": 3,
                    "indices": { "bufferView": 2, "componentType": 5121 },
                    "values": { "bufferView": 0, "byteOffset": 12 },
                });
                positions.insert("sparse".into(), sparse);
            }),
            None,
        );
        match mesh {
            Ok(mesh) => {
                assert!(read);
                let cell = normalise(&mesh, Path::new("sparse"), &CellOptions::default());
                assert_eq!(cell.expect("a cell").facets, single.facets);
            }
            Err(fault) => assert!(
                !read && fault.to_string().contains("sparse index"),
                "{fault}"
            ),
        }
    }
}

/// The document of `embedded.gltf` with changes to its JSON and its buffer.
fn document(change: impl FnOnce(&mut Value, &mut Vec<u8>)) -> Vec<u8> {
    let engine = base64::engine::general_purpose::STANDARD;
    let text = std::fs::read_to_string(folder("good/embedded.gltf")).expect("reads");
    let mut json: Value = serde_json::from_str(&text).expect("JSON");
    let uri = json["buffers"][0]["uri"].as_str().expect("a text");
    let (start, packed) = uri.split_once(',').expect("data");
    let (start, mut buffer) = (start.to_owned(), engine.decode(packed).expect("base64"));
    change(&mut json, &mut buffer);
    json["buffers"][0] = json!({
        "byteLength": buffer.len(),
        "uri": format!("{start},{}", engine.encode(&buffer)),
    });
    json.to_string().into_bytes()
}

/// Integers of 8 and 16 bits, normalised or not (`KHR_mesh_quantization`): a corner of the single
/// cube at the integer k lies at k, or at k over the largest integer, in units of the node's scale.
/// A signed integer below 0 lies as far on the other side, and the least one at -1.
#[test]
fn quantised_positions_are_read() {
    let types: [(u32, i64, i64, usize); 4] = [
        (5120, -128, 127, 1),
        (5121, 0, 255, 1),
        (5122, -32768, 32767, 2),
        (5123, 0, 65535, 2),
    ];
    let mut cases = 0;
    for (component, least, largest, width) in types {
        for normalized in [false, true] {
            for at in [100, largest, least] {
                if at == 0 {
                    continue;
                }
                let bytes = document(|json, buffer| {
                    let start = buffer.len();
                    for corner in 0..4 {
                        let own = [0, 1, 2].map(|axis| if axis + 1 == corner { at } else { 0 });
                        let vertex = own.map(|k| k.to_le_bytes()[..width].to_vec()).concat();
                        buffer.extend(vertex);
                        buffer.resize(start + (corner + 1) * 4 * width, 0);
                    }
                    json["bufferViews"][0] = json!({
                        "buffer": 0, "byteOffset": start, "byteLength": 16 * width,
                        "byteStride": 4 * width,
                    });
                    let accessor = &mut json["accessors"][0];
                    accessor["componentType"] = component.into();
                    accessor["normalized"] = normalized.into();
                    accessor["min"] = json!([at.min(0), at.min(0), at.min(0)]);
                    accessor["max"] = json!([at.max(0), at.max(0), at.max(0)]);
                    json["nodes"][0]["scale"] = json!([2, 2, 2]);
                    json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
                    json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
                });
                let mesh = gltf::parse(&bytes, None).unwrap_or_else(|e| panic!("{e}"));
                let unit = if normalized {
                    2.0 / largest as f64
                } else {
                    2.0
                };
                let expected = match normalized {
                    true => (unit * at as f64).max(-2.0),
                    false => unit * at as f64,
                };
                let found = mesh.positions[1].x;
                assert!(
                    (found / expected - 1.0).abs() < 4e-16,
                    "{component} {at}: {found}"
                );
                assert_eq!(mesh.positions[1].y, 0.0);
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 20);
}

/// A changed buffer must change the hash, even if the document stays unchanged.
#[test]
fn the_hash_covers_external_buffers() {
    let copy = tempfile::tempdir().expect("a temporary folder");
    for file in ["external.gltf", "external buffer.bin"] {
        std::fs::copy(folder("good").join(file), copy.path().join(file)).expect("a copy");
    }
    let hash = || {
        meshes::load(&copy.path().join("external.gltf"))
            .expect("a mesh")
            .hash
    };
    let before = hash();
    let buffer = copy.path().join("external buffer.bin");
    let mut bytes = std::fs::read(&buffer).expect("the buffer");
    bytes[14] ^= 1;
    std::fs::write(&buffer, bytes).expect("a changed buffer");
    assert_ne!(before, hash());
}

/// Index by wavelength with an Abbe number (KHR_materials_dispersion holds 20 / V_d): the file's
/// own index at the d line, and a difference of (n - 1)/V_d between the F and C lines.
#[test]
fn dispersion_of_a_file() {
    let plain = std::fs::read_to_string(folder("good/prism_with_index.gltf")).expect("reads");
    let mut document: serde_json::Value = serde_json::from_str(&plain).expect("JSON");
    document["materials"][0]["extensions"]["KHR_materials_dispersion"] =
        serde_json::json!({ "dispersion": 20.0 / 57.0 });
    let place = tempfile::tempdir().expect("a folder");
    let file = place.path().join("prism.gltf");
    std::fs::write(&file, document.to_string()).expect("writes");
    let cell = load_cell(&file, &CellOptions::default()).expect("a prism");
    let at = |nm| cell.refractive_index_at(Some(nm)).expect("an index");
    // The constants of the extension have four and six digits.
    assert!((at(587.56) - 1.49).abs() < 1e-6);
    assert!((at(486.13) - at(656.27) - 0.49 / 57.0).abs() < 1e-6);
    assert_eq!(cell.refractive_index_at(None), Some(1.49));
}
