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

use crate::cli::{datasheet, design, optimise, trace};
use crate::error::Error;

pub use crate::cli::datasheet::Sheets;
pub use crate::cli::optimise::Best;
pub use tables::cli::Refused;

/// Caller of a bake or of other long work: it is told the progress, and may stop the work.
#[derive(Clone, Copy)]
pub struct Caller<'a> {
    /// Function that is told how many rays (steps, cells) are done, and how many there are in all;
    /// `None` if the bake runs to a tolerance.
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

/// Makes the data sheet of a cell, or of two compared, as `bake datasheet` does.
///
/// Meshes in memory take the places of the files.
///
/// # Errors
/// Returns [`Refused`] if the words or a mesh cannot be used, or if the caller stopped it.
pub fn datasheet(
    words: &[OsString],
    held: [Option<&Mesh>; 2],
    caller: Caller,
) -> Result<Sheets, Refused> {
    Ok(datasheet::called(&parsed(words)?, held, &caller)?)
}

/// Searches the best cell of a goal, as `bake optimise` does.
///
/// # Errors
/// Returns [`Refused`] if the words or the goal cannot be used, if no cell meets the goal, or if the
/// caller stopped it.
pub fn optimise(words: &[OsString], caller: Caller) -> Result<Best, Refused> {
    Ok(optimise::called(&parsed(words)?, &caller)?)
}

/// Writes a mesh in the format that the extension of `output` names, as `bake design` does.
///
/// # Errors
/// Returns [`Refused`] if there is no such format, or if the file cannot be written.
pub fn write(mesh: &Mesh, output: &Path) -> Result<(), Refused> {
    Ok(design::write(mesh, output)?)
}
