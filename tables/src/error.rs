//! Errors of tables and command lines: one sentence each, with the place and the remedy.

use std::path::{Path, PathBuf};

/// Remedy for a table that is too large.
pub(crate) const BAKE_LESS: &str = "bake fewer directions or bins";

/// Reason why a table could not be read, written, merged or looked up, or a result not be printed.
///
/// Each message is one sentence that names the place and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// File that cannot be read or written, or that holds no sound table.
    #[error("{}: {fault}; {remedy}", file.display())]
    File {
        /// Path of the file.
        file: PathBuf,
        /// Fault, with the dataset or attribute in which it is.
        fault: String,
        /// Remedy.
        remedy: &'static str,
    },
    /// Refusal of the process that reads tables, a sentence like the others here.
    #[error("{0}")]
    Told(String),
    /// Tables that cannot be merged. Tables are numbered from 0.
    #[error("{fault}; {remedy}")]
    Merge {
        /// Field or rays, and the tables that contradict one another.
        fault: String,
        /// Remedy.
        remedy: String,
    },
    /// Direction that the table cannot answer for, with the remedy.
    #[error("{0}")]
    Direction(String),
    /// Table that does not say how its cubes turn the polarisation.
    #[error(
        "polarised light needs to know how each path turns the polarisation, which the table does \
        not hold (it has losses or total reflection, and no Jones matrices); bake it again with \
        --method exact and single azimuths, or leave polarisation, analyser, retarder and half \
        mirrors with s and p out"
    )]
    Polarised,
    /// Table that does not say which cubes its paths belong to, so dihedral errors cannot be added.
    #[error(
        "the table does not say which cubes its paths belong to, so dihedral_errors_mrad cannot be \
        added to it; bake it again with --method exact and single azimuths"
    )]
    Cubeless,
    /// Extension of a plot that is not .svg.
    #[error("{}: the extension must be .svg; browsers show and print SVG, and Inkscape makes PNG or PDF \
        of it", .0.display())]
    PlotExtension(PathBuf),
    /// Standard output that cannot be written.
    ///
    /// A closed pipe is no error: its reader has seen enough.
    #[error(
        "standard output cannot be written ({0}); check the pipe, free some space, or use -o \
        where the verb has it"
    )]
    Stdout(std::io::Error),
    /// Threads that could not be started.
    #[error("--threads {threads}: the threads could not be started ({reason}); ask for fewer")]
    Threads {
        /// Number of threads that were asked for; 0 for one per core.
        threads: usize,
        /// Reason that the thread library gives.
        reason: String,
    },
}

impl Error {
    /// Makes the error of a file.
    pub fn file(file: &Path, fault: impl ToString, remedy: &'static str) -> Error {
        Error::File {
            file: file.to_owned(),
            fault: fault.to_string(),
            remedy,
        }
    }
}
