//! Loading of a mesh from a file, by its extension.

use std::path::Path;

use crate::files::bounded::{MAX_BYTES, read_bounded};
use crate::files::{gltf, obj, ply, stl};
use crate::mesh::error::{Error, Fault};
use crate::mesh::mesh::Mesh;

/// Reads an OBJ, glTF, GLB, STL or PLY file, by its extension.
///
/// # Errors
/// Fails if the file is missing, has another extension, is larger than 128 MiB, has more than 2^21
/// vertices or triangles, or is malformed.
pub fn load(path: &Path) -> Result<Mesh, Error> {
    let extension = path
        .extension()
        .map(|e| e.to_string_lossy().to_lowercase())
        .unwrap_or_default();
    let bytes = match extension.as_str() {
        "obj" | "gltf" | "glb" | "stl" | "ply" => {
            read_bounded(path, MAX_BYTES).map_err(|fault| Error::new(path, fault))?
        }
        _ => return Err(Error::new(path, Fault::UnknownExtension { extension })),
    };
    let mut mesh = match extension.as_str() {
        "obj" => obj::parse(&bytes),
        "stl" => stl::parse(&bytes),
        "ply" => ply::parse(&bytes),
        _ => gltf::parse(&bytes, path.parent()),
    }
    .map_err(|fault| Error::new(path, fault))?;
    if mesh.design.is_empty() {
        mesh.design = path
            .file_stem()
            .map(|stem| stem.to_string_lossy().into_owned())
            .unwrap_or_default();
    }
    Ok(mesh)
}
