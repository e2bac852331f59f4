//! Where the project's own files lie, and tables baked for a test.

use std::path::{Path, PathBuf};

use crate::program::bake;

/// The root of the project.
pub fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("this crate lies in the project")
        .to_owned()
}

/// A file of the project as an argument: `parts` is its path from the root.
pub fn argument(parts: &str) -> String {
    project().join(parts).display().to_string()
}

/// Bakes a design into a table in `folder` and returns its name: behind a front face of index 1.49,
/// like the acrylic of the campaigns, otherwise as `bake trace` does without being told.
pub fn bake_table(folder: &Path, design: &str, incidence: &str, azimuth: &str) -> String {
    bake_table_with(folder, design, incidence, azimuth, &[])
}

/// Likewise, with further options.
pub fn bake_table_with(
    folder: &Path,
    design: &str,
    incidence: &str,
    azimuth: &str,
    options: &[&str],
) -> String {
    let mesh = format!("{design}.obj");
    let table = format!("{design}-{azimuth}.h5");
    bake(folder, &["design", design, "-o", &mesh]).done();
    let directions = ["--incidence", incidence, "--azimuth", azimuth];
    let files = ["trace", &mesh, "-o", &table, "--refractive-index", "1.49"];
    bake(folder, &[&files[..], &directions, options].concat()).done();
    table
}
