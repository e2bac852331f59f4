//! Paths of the project's own files, and tables that are baked for a test.

use std::path::{Path, PathBuf};

use crate::program::bake;

/// Returns the root folder of the project.
pub fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("this crate lies in the project")
        .to_owned()
}

/// Returns the full path of a file of the project as text, for a command line.
///
/// `parts` is the path from the root of the project.
pub fn argument(parts: &str) -> String {
    project().join(parts).display().to_string()
}

/// Bakes a design into a table in `folder` and returns the table's file name.
///
/// The refractive index is 1.49, as in the campaigns (acrylic). All other options have the
/// defaults of `bake trace`.
pub fn bake_table(folder: &Path, design: &str, incidence: &str, azimuth: &str) -> String {
    bake_table_with(folder, design, incidence, azimuth, "")
}

/// Bakes a design as [`bake_table`] does, with further options of `bake trace`, and returns the
/// table's file name.
pub fn bake_table_with(
    folder: &Path,
    design: &str,
    incidence: &str,
    azimuth: &str,
    options: &str,
) -> String {
    let mesh = format!("{design}.obj");
    let table = format!("{design}-{azimuth}.h5");
    bake(folder, &format!("design {design} -o {mesh}")).done();
    let directions = format!("--incidence {incidence} --azimuth {azimuth}");
    let files = format!("trace {mesh} -o {table} --refractive-index 1.49");
    bake(folder, &format!("{files} {directions} {options}")).done();
    table
}
