//! Functions under fuzzing: each gives some bytes to one reader of the project.
//!
//! The reader must return a value or an error. The fuzz targets call these functions with random
//! bytes. `tests/tests/all/files/corpus.rs` calls them with the files of `fuzz/corpus`.

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

/// Reads the bytes as an STL file and makes the cell that `bake` traces.
pub fn stl(bytes: &[u8]) {
    cell(meshes::stl::parse(bytes));
}

/// Reads the bytes as a PLY file and makes the cell that `bake` traces.
pub fn ply(bytes: &[u8]) {
    cell(meshes::ply::parse(bytes));
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

/// Exact table of the corpus, honest.
static EXACT: LazyLock<tables::Table> = LazyLock::new(|| {
    let path = file("exact.h5", include_bytes!("../corpus/table/exact.h5"));
    tables::read(&path).expect("the corpus holds an honest table")
});

/// Reads the bytes as a result.json, and predicts with it.
pub fn result(bytes: &[u8]) {
    let Ok(mut result) = serde_json::from_slice::<fit::ResultFile>(bytes) else {
        return;
    };
    // Else nearly every result would be refused as that of another cell.
    result.table = fit::TableResult::of(&EXACT);
    let places = fit::Places {
        floating_distance_mm: vec![1.0, 300.0],
        incidence_deg: EXACT.axes.incidence_deg.clone(),
        azimuth_deg: EXACT.axes.azimuth_deg.first().copied(),
        frequency_per_mm: vec![0.0, 0.5, 5.0],
    };
    let _ = fit::predict_mtf(&result, &EXACT, &places);
}

/// Table of all azimuths, honest: a view shows each pixel at its own azimuth.
static ALL_ROUND: LazyLock<tables::Table> = LazyLock::new(|| {
    let path = file("all_round.h5", include_bytes!("../all_round.h5"));
    tables::read(&path).expect("this folder holds an honest table")
});

/// Result of the corpus for the table [`ALL_ROUND`], honest.
static FITTED: LazyLock<fit::ResultFile> = LazyLock::new(|| {
    let result = serde_json::from_slice(include_bytes!("../corpus/result/honest"));
    let mut result: fit::ResultFile = result.expect("the corpus holds an honest result");
    result.table = fit::TableResult::of(&ALL_ROUND);
    result
});

/// Reads the bytes as a VIEW.toml, and renders a small picture as its camera sees it. What is
/// rendered must be finite.
pub fn view(bytes: &[u8]) {
    let path = file("view.toml", bytes);
    if let Ok(image) = fit::cli::render_view(&path, &FITTED, &ALL_ROUND) {
        let finite = image.planes.iter().flatten().all(|value| value.is_finite());
        assert!(finite, "{:?}", image.planes);
    }
}

/// Changes numbers of the polygons of an honest table; its spectrum must be finite if the rules of
/// tables let it pass.
///
/// Twelve bytes are a change: the path, the number within it, and its new value.
pub fn polygons(bytes: &[u8]) {
    let mut table = EXACT.clone();
    let Some(exact) = table.exact.as_mut() else {
        return;
    };
    let mut paths: Vec<&mut tables::Path> = exact.paths.iter_mut().flatten().collect();
    for change in bytes.as_chunks::<12>().0 {
        let [p0, p1, n0, n1, value @ ..] = *change;
        let path = usize::from(u16::from_le_bytes([p0, p1])) % paths.len();
        let path = &mut *paths[path];
        let numbers = path
            .matrix
            .as_flattened_mut()
            .iter_mut()
            .chain(&mut path.offset)
            .chain(&mut path.deviation)
            .chain([&mut path.weight])
            .chain(path.polygon.as_flattened_mut());
        let mut numbers: Vec<&mut f64> = numbers.collect();
        let number = usize::from(u16::from_le_bytes([n0, n1])) % numbers.len();
        *numbers[number] = f64::from_le_bytes(value);
    }
    if tables::check(&table).is_err() {
        return;
    }
    let azimuth = table.axes.azimuth_deg.first().copied();
    for &incidence in &table.axes.incidence_deg {
        let Ok(direction) = table.direction(incidence, azimuth) else {
            continue;
        };
        let otf = direction.otf_along([0.8, 0.6], &[0.0, 0.1, 10.0]);
        assert!(otf.iter().all(|value| value.is_finite()), "{otf:?}");
    }
}
