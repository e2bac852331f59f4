//! The verbs for a program that calls them in its own process, as the Python package does.
//!
//! Options enter as the words of a command line, so they have one meaning, one default and one
//! refusal everywhere. Meshes and tables leave. Nothing is printed or written.

use std::ffi::OsString;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use meshes::Mesh;
use tables::Table;
use tables::cli::parsed;

use crate::cli::{design, trace};
use crate::error::Error;

pub use tables::cli::Refused;

/// Caller of a bake: it is told the progress, and may stop the bake.
#[derive(Clone, Copy)]
pub struct Caller<'a> {
    /// Function that is told how many rays are done, and how many there are in all; `None` if the
    /// bake runs to a tolerance.
    ///
    /// The call may come from any thread.
    pub told: &'a (dyn Fn(u64, Option<u64>) + Sync),
    /// Flag that stops the bake.
    pub stop: &'a AtomicBool,
}

impl From<Error> for Refused {
    fn from(error: Error) -> Refused {
        match error {
            Error::Stopped => Refused::Stopped,
            error => Refused::Sentence(error.to_string()),
        }
    }
}

/// Returns the mesh of a design, as `bake design` writes it and a reader reads it.
///
/// # Errors
/// Returns [`Refused`] if the words cannot be used.
pub fn design(words: &[OsString]) -> Result<Mesh, Refused> {
    Ok(design::read_back(&parsed(words)?)?)
}

/// Bakes a table, as `bake trace` does, and returns it with the warnings.
///
/// A `mesh` in memory takes the place of the file.
///
/// # Errors
/// Returns [`Refused`] if the words or the mesh cannot be used, if the bake fails, or if the caller
/// stopped it.
pub fn trace(
    words: &[OsString],
    mesh: Option<&Mesh>,
    caller: Caller,
) -> Result<(Table, Vec<String>), Refused> {
    Ok(trace::called(&parsed(words)?, mesh, &caller)?)
}

/// Writes a mesh in the format that the extension of `output` names, as `bake design` does.
///
/// # Errors
/// Returns [`Refused`] if there is no such format, or if the file cannot be written.
pub fn write(mesh: &Mesh, output: &Path) -> Result<(), Refused> {
    Ok(design::write(mesh, output)?)
}
