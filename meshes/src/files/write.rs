//! Writing of meshes: OBJ in full f64 digits, GLB in f32.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fs;
use std::path::Path;

use glam::DVec3;
use serde_json::{Value, json};

use crate::files::glb;
use crate::mesh::error::{Error, Fault};
use crate::mesh::mesh::{GLASS, Mesh};

/// Writes a number in the fewest digits that read back as the same f64.
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

/// Writes the coordinates of vectors with a separator.
fn joined(vectors: &[DVec3], separator: &str) -> String {
    let words: Vec<String> = vectors
        .iter()
        .flat_map(|v| v.to_array())
        .map(digits)
        .collect();
    words.join(separator)
}

/// Returns the mesh as OBJ text.
///
/// It has `# design`, `# lattice`, `# edge_length`, `# azimuth_zero` and `# hollow` comments if the
/// mesh has these, then `v` and `f` lines, `vn` lines if it has normals, and `usemtl` lines if some
/// faces are of glass. Every coordinate reads back as the same f64.
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
    if let Some(direction) = mesh.azimuth_zero {
        line(format!("# azimuth_zero {}", joined(&[direction], ",")));
    }
    if mesh.hollow {
        line("# hollow".into());
    }
    for &p in &mesh.positions {
        line(format!("v {}", joined(&[p + mesh.origin], " ")));
    }
    for &n in &mesh.normals {
        line(format!("vn {}", joined(&[n], " ")));
    }
    let mut glass = None;
    for (triangle, vertices) in mesh.triangles.iter().enumerate() {
        let material = (!mesh.glass.is_empty()).then(|| mesh.is_glass(triangle));
        if material != glass {
            glass = material;
            line(format!(
                "usemtl {}",
                if material == Some(true) {
                    GLASS
                } else {
                    "mirror"
                }
            ));
        }
        let numbers = mesh.corner_normals.get(triangle).unwrap_or(&[None; 3]);
        let [a, b, c] = [0, 1, 2].map(|corner| {
            let vertex = u64::from(vertices[corner]) + 1;
            numbers[corner].map_or(vertex.to_string(), |normal| format!("{vertex}//{normal}"))
        });
        line(format!("f {a} {b} {c}"));
    }
    text
}

/// Returns the mesh with one vertex for each normal at it, and these normals.
///
/// If not every corner has a normal, it returns the mesh itself and no normals.
fn with_normals(mesh: &Mesh) -> (Cow<'_, Mesh>, Vec<DVec3>) {
    let corners = mesh.triangles.iter().zip(&mesh.corner_normals);
    let given = corners.flat_map(|(vertices, numbers)| vertices.iter().copied().zip(*numbers));
    let pairs: Vec<(u32, DVec3)> = given
        .filter_map(|(vertex, number)| {
            let normal = mesh.normals.get(number?.get() as usize - 1)?;
            Some((vertex, *normal))
        })
        .collect();
    if mesh.triangles.is_empty() || pairs.len() != 3 * mesh.triangles.len() {
        return (Cow::Borrowed(mesh), Vec::new());
    }
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    let mut known = HashMap::new();
    let vertices: Vec<u32> = pairs
        .into_iter()
        .map(|(vertex, normal)| {
            let key = (vertex, normal.to_array().map(f64::to_bits));
            *known.entry(key).or_insert_with(|| {
                positions.push(mesh.positions[vertex as usize]);
                normals.push(normal);
                positions.len() as u32 - 1
            })
        })
        .collect();
    let triangles = vertices.as_chunks::<3>().0.to_vec();
    let split = Mesh {
        positions,
        triangles,
        ..mesh.clone()
    };
    (Cow::Owned(split), normals)
}

/// Returns what glTF has no place for: design, lattice, edge length, azimuth zero, and whether the
/// cubes are hollow.
fn extras(mesh: &Mesh) -> serde_json::Map<String, Value> {
    let mut extras = serde_json::Map::new();
    extras.insert("design".into(), mesh.design.as_str().into());
    if let Some([a, b]) = mesh.lattice {
        extras.insert("lattice".into(), json!([a.x, a.y, a.z, b.x, b.y, b.z]));
    }
    if let Some(length) = mesh.edge_length {
        extras.insert("edge_length".into(), length.into());
    }
    if let Some(direction) = mesh.azimuth_zero {
        extras.insert("azimuth_zero".into(), json!(direction.to_array()));
    }
    if mesh.hollow {
        extras.insert("hollow".into(), true.into());
    }
    extras
}

/// Returns the mesh as a GLB file.
///
/// It has one primitive, f32 positions, u32 indices, `extras` of the document for design, lattice,
/// edge length and azimuth zero (f64), and `KHR_materials_ior` if there is a refractive index.
/// Normals are written if every corner has one; a vertex with several normals is written several
/// times.
///
/// f32 keeps 6e-8 of a coordinate: dihedral errors below 1e-7 rad need OBJ.
pub fn glb(mesh: &Mesh) -> Vec<u8> {
    let (mesh, normals) = with_normals(mesh);
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
    let triangles_end = binary.len();
    let normals: Vec<[f32; 3]> = normals.iter().map(|n| n.as_vec3().to_array()).collect();
    binary.extend(normals.iter().flatten().flat_map(|x| x.to_le_bytes()));
    let mut document = json!({
        "asset": { "version": "2.0", "generator": "bake design" },
        "extras": extras(&mesh),
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "buffers": [{ "byteLength": binary.len() }],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": split, "target": 34962 },
            {
                "buffer": 0, "byteOffset": split, "byteLength": triangles_end - split,
                "target": 34963,
            },
        ],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": positions.len(),
                "min": bound(f32::min), "max": bound(f32::max),
            },
            {
                "bufferView": 1, "componentType": 5125, "type": "SCALAR",
                "count": 3 * mesh.triangles.len(),
            },
        ],
    });
    if !normals.is_empty() {
        document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 2.into();
        if let Some(views) = document["bufferViews"].as_array_mut() {
            let length = binary.len() - triangles_end;
            views.push(json!({
                "buffer": 0, "byteOffset": triangles_end, "byteLength": length, "target": 34962
            }));
        }
        if let Some(accessors) = document["accessors"].as_array_mut() {
            accessors.push(json!({
                "bufferView": 2, "componentType": 5126, "type": "VEC3", "count": normals.len()
            }));
        }
    }
    if let Some(index) = mesh.refractive_index {
        document["extensionsUsed"] = json!(["KHR_materials_ior"]);
        document["materials"] =
            json!([{ "extensions": { "KHR_materials_ior": { "ior": index } } }]);
        document["meshes"][0]["primitives"][0]["material"] = Value::from(0);
    }
    glb::file(&document.to_string(), &binary)
}

/// Writes the mesh to `path`, as OBJ or GLB by its extension.
///
/// It writes a temporary file beside `path` and renames it, so that an interrupted write leaves an
/// older file whole.
///
/// # Errors
/// Returns [`Fault::UnknownExtension`] for another extension, and [`Fault::Unwritable`] if the file
/// cannot be written.
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
        // Remove the temporary file. If this fails too, the first error is still the one to report.
        let _ = fs::remove_file(&temporary);
        Error::new(path, Fault::Unwritable(error))
    })
}
