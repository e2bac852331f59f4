//! Writing meshes: OBJ in full f64 digits, GLB in f32.

use std::fs;
use std::path::Path;

use glam::DVec3;
use serde_json::{Value, json};

use crate::error::{Error, Fault};
use crate::glb;
use crate::mesh::Mesh;

/// A number in the fewest digits that read back as the same f64.
fn digits(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 {
        "0".to_owned()
    } else if (1e-5..1e16).contains(&magnitude) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

fn joined(vectors: &[DVec3], separator: &str) -> String {
    let words: Vec<String> = vectors
        .iter()
        .flat_map(|v| v.to_array())
        .map(digits)
        .collect();
    words.join(separator)
}

/// The mesh as OBJ text: `# design`, `# lattice` and `# edge_length` comments where the mesh has them, then `v` and `f`
/// lines. Every coordinate reads back as the same f64.
pub fn obj(mesh: &Mesh) -> String {
    let mut text = String::new();
    let mut line = |content: String| {
        text.push_str(&content);
        text.push('\n');
    };
    if !mesh.design.is_empty() {
        line(format!(
            "# design {}",
            mesh.design.replace(['\n', '\r'], " ")
        ));
    }
    if let Some(lattice) = &mesh.lattice {
        line(format!("# lattice {}", joined(lattice, ",")));
    }
    if let Some(length) = mesh.edge_length {
        line(format!("# edge_length {}", digits(length)));
    }
    for &p in &mesh.positions {
        line(format!("v {}", joined(&[p + mesh.origin], " ")));
    }
    for [a, b, c] in &mesh.triangles {
        line(format!(
            "f {} {} {}",
            u64::from(*a) + 1,
            u64::from(*b) + 1,
            u64::from(*c) + 1
        ));
    }
    text
}

/// The mesh as a GLB file: one primitive, f32 positions, u32 indices, `extras` of the document for design, lattice and
/// edge length (f64), and `KHR_materials_ior` where there is a refractive index.
///
/// f32 keeps 6e-8 of a coordinate: dihedral errors below 1e-7 rad need OBJ.
pub fn glb(mesh: &Mesh) -> Vec<u8> {
    let positions: Vec<[f32; 3]> = mesh
        .positions
        .iter()
        .map(|&p| (p + mesh.origin).as_vec3().to_array())
        .collect();
    let bound = |pick: fn(f32, f32) -> f32| {
        let axis = |k: usize| positions.iter().map(|p| p[k]).reduce(pick).unwrap_or(0.0);
        [axis(0), axis(1), axis(2)]
    };
    let mut binary: Vec<u8> = positions
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let split = binary.len();
    binary.extend(
        mesh.triangles
            .iter()
            .flatten()
            .flat_map(|v| v.to_le_bytes()),
    );
    let mut extras = serde_json::Map::new();
    extras.insert("design".into(), mesh.design.as_str().into());
    if let Some([a, b]) = mesh.lattice {
        extras.insert("lattice".into(), json!([a.x, a.y, a.z, b.x, b.y, b.z]));
    }
    if let Some(length) = mesh.edge_length {
        extras.insert("edge_length".into(), length.into());
    }
    let mut document = json!({
        "asset": { "version": "2.0", "generator": "bake design" },
        "extras": extras,
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "buffers": [{ "byteLength": binary.len() }],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": split, "target": 34962 },
            { "buffer": 0, "byteOffset": split, "byteLength": binary.len() - split, "target": 34963 },
        ],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": positions.len(),
                "min": bound(f32::min), "max": bound(f32::max),
            },
            { "bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": 3 * mesh.triangles.len() },
        ],
    });
    if let Some(index) = mesh.refractive_index {
        document["extensionsUsed"] = json!(["KHR_materials_ior"]);
        document["materials"] =
            json!([{ "extensions": { "KHR_materials_ior": { "ior": index } } }]);
        document["meshes"][0]["primitives"][0]["material"] = Value::from(0);
    }
    glb::file(&document.to_string(), &binary)
}

/// Writes the mesh to `path`, as OBJ or GLB by its extension, through a temporary file beside it: an interrupted write
/// leaves an older file whole.
///
/// # Errors
/// [`Fault::UnknownExtension`] and [`Fault::Unwritable`].
pub fn save(mesh: &Mesh, path: &Path) -> Result<(), Error> {
    let extension = path
        .extension()
        .map(|e| e.to_string_lossy().to_lowercase())
        .unwrap_or_default();
    let bytes = match extension.as_str() {
        "obj" => obj(mesh).into_bytes(),
        "glb" => glb(mesh),
        _ => return Err(Error::new(path, Fault::UnknownExtension { extension })),
    };
    let temporary = path.with_extension(format!("{extension}.{}.partial", std::process::id()));
    let written = fs::write(&temporary, bytes).and_then(|()| fs::rename(&temporary, path));
    written.map_err(|error| {
        // Nothing is left behind; that this may fail too changes nothing about the first error.
        let _ = fs::remove_file(&temporary);
        Error::new(path, Fault::Unwritable(error))
    })
}
