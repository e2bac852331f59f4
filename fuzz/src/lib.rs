//! Functions under fuzzing: each gives some bytes to one reader of the project.
//!
//! The reader must return a value or an error. The fuzz targets call these functions with random
//! bytes. `tests/tests/all/corpus.rs` calls them with the files of `fuzz/corpus`.

#![allow(
    unreachable_pub,
    reason = "the fuzz targets are other crates; the corpus test includes this file"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// Temporary folder of this process, in memory (`/dev/shm`) if the machine has such a file system.
static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() {
        tempfile::tempdir_in(memory)
    } else {
        tempfile::tempdir()
    };
    folder.expect("a temporary folder can be made")
});

/// Writes the bytes to a file in [`FOLDER`] and returns its path.
fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = FOLDER.path().join(name);
    fs::write(&path, bytes).expect("a temporary file can be written");
    path
}

/// Makes a mesh that was read into the cell that `bake` traces.
fn cell(mesh: Result<meshes::Mesh, meshes::Fault>) {
    if let Ok(mesh) = mesh {
        let _ = meshes::normalise(&mesh, Path::new("fuzzed"), &meshes::CellOptions::default());
    }
}

/// Reads the bytes as a Wavefront OBJ file and makes the cell that `bake` traces.
pub fn obj(bytes: &[u8]) {
    cell(meshes::obj::parse(bytes));
}

/// Reads the bytes as a glTF or GLB file and makes the cell that `bake` traces.
///
/// The file has no buffers in other files.
pub fn gltf(bytes: &[u8]) {
    cell(meshes::gltf::parse(bytes, None));
}

/// Reads the bytes as an HDF5 table.
///
/// The tables of the corpus have no seal. With a seal, every changed table would be refused before
/// it reaches the HDF5 library and the check of the content hash.
pub fn table(bytes: &[u8]) {
    let path = file("table.h5", bytes);
    let _ = tables::read(&path);
}

/// Reads the bytes as a photograph, and its camera settings from Exif.
///
/// The file name has no ending, so the content decides on the format.
pub fn photograph(bytes: &[u8]) {
    let path = file("photograph", bytes);
    let _ = fit::load_photo(&path, &fit::Decode::default());
    let _ = fit::Settings::of(&path);
}

/// Reads the bytes as a manifest, as the ranges of a study and as the parameters of a simulation.
pub fn toml(bytes: &[u8]) {
    let path = file("fuzzed.toml", bytes);
    let _ = fit::load_campaign(&path);
    let _ = fit::StudyRanges::load(&path);
    let _ = fit::SimulationParams::load(&path);
}
