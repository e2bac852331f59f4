//! What is fuzzed: each function gives some bytes to one door of the project, which must answer
//! with a value or an error. The fuzz targets call them, and `tests/tests/all/corpus.rs` does so
//! over the kept corpus.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// A folder of this process, in memory where there is such a file system.
static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() {
        tempfile::tempdir_in(memory)
    } else {
        tempfile::tempdir()
    };
    folder.expect("a temporary folder can be made")
});

fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = FOLDER.path().join(name);
    fs::write(&path, bytes).expect("a temporary file can be written");
    path
}

fn cell(mesh: Result<meshes::Mesh, meshes::Fault>) {
    if let Ok(mesh) = mesh {
        let _ = meshes::normalise(&mesh, Path::new("fuzzed"), &meshes::CellOptions::default());
    }
}

/// A Wavefront OBJ file, to the cell that is traced.
pub(super) fn obj(bytes: &[u8]) {
    cell(meshes::obj::parse(bytes));
}

/// A glTF or GLB file without files beside it, to the cell that is traced.
pub(super) fn gltf(bytes: &[u8]) {
    cell(meshes::gltf::parse(bytes, None));
}

/// An HDF5 table. The tables of the corpus have no seal, so that a changed one reaches the HDF5
/// library and its content hash.
pub(super) fn table(bytes: &[u8]) {
    let path = file("table.h5", bytes);
    let _ = tables::read(&path);
}

/// A photograph of any format: what it holds decides, not its name.
pub(super) fn photograph(bytes: &[u8]) {
    let path = file("photograph", bytes);
    let _ = fit::load_photo(&path, &fit::Decode::default());
    let _ = fit::Settings::of(&path);
}

/// A manifest of captures, ranges of a study and parameters of a simulation.
pub(super) fn toml(bytes: &[u8]) {
    let path = file("fuzzed.toml", bytes);
    let _ = fit::load_campaign(&path);
    let _ = fit::StudyRanges::load(&path);
    let _ = fit::SimulationParams::load(&path);
}
