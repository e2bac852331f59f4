//! Loading of a mesh from a file, by its extension, and bounds of what is read.

use crate::files::{gltf, obj, ply, stl};
use crate::mesh::error::{Error, Fault};
use crate::mesh::mesh::{MAX_ELEMENTS, Mesh};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Reads an OBJ, glTF, GLB, STL or PLY file, by its extension.
///
/// # Errors
/// Fails if the file is missing or a folder, has another extension, is larger than 128 MiB, has more
/// than 2^21 vertices or triangles, or is malformed.
pub fn load(path: &Path) -> Result<Mesh, Error> {
    let extension = path
        .extension()
        .map(|e| e.to_string_lossy().to_lowercase())
        .unwrap_or_default();
    if path.is_dir() {
        return Err(Error::new(path, Fault::Folder));
    }
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

/// Largest file, and most bytes of all buffers of a mesh.
///
/// Sheets of thousands of cells take some MiB. With [`MAX_ELEMENTS`] it keeps the memory of a mesh
/// below 1 GiB.
pub(crate) const MAX_BYTES: u64 = 1 << 27;

/// Checks that a number of elements is at most [`MAX_ELEMENTS`], before anything of its size is
/// allocated.
pub(crate) fn within(what: &'static str, found: usize) -> Result<(), Fault> {
    let (found, limit) = (found as u64, MAX_ELEMENTS as u64);
    match found > limit {
        true => Err(Fault::TooLarge { what, found, limit }),
        false => Ok(()),
    }
}

/// Reads a regular file of at most `limit` bytes.
///
/// A pipe would wait for its writer, and a device may never end. The size is checked before and
/// while reading, because the file may grow.
pub(crate) fn read_bounded(path: &Path, limit: u64) -> Result<Vec<u8>, Fault> {
    let regular = |metadata: &std::fs::Metadata| match metadata.is_file() {
        true => Ok(()),
        false => Err(Fault::NotAFile),
    };
    // Opening a pipe would wait already.
    regular(&std::fs::metadata(path).map_err(Fault::Unreadable)?)?;
    let file = File::open(path).map_err(Fault::Unreadable)?;
    let metadata = file.metadata().map_err(Fault::Unreadable)?;
    regular(&metadata)?;
    if metadata.len() > limit {
        return Err(Fault::TooLarge {
            what: "bytes",
            found: metadata.len(),
            limit,
        });
    }
    let mut bytes = Vec::new();
    file.take(limit + 1)
        .read_to_end(&mut bytes)
        .map_err(Fault::Unreadable)?;
    if bytes.len() as u64 > limit {
        return Err(Fault::TooLarge {
            what: "bytes",
            found: bytes.len() as u64,
            limit,
        });
    }
    Ok(bytes)
}
