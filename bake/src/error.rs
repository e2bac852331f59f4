//! Errors of bakes: one sentence each, with what is wrong, where, and the remedy.

use meshes::Fault;

/// Reason why a bake, a check of a table, or a verb of the program failed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Options that cannot be read, are out of range, or exclude each other.
    #[error("{0}")]
    Usage(String),
    /// Mesh that cannot be read, or is no cell.
    #[error(transparent)]
    Mesh(#[from] meshes::Error),
    /// Table or other file that cannot be read or written, or threads that do not start.
    #[error(transparent)]
    Table(#[from] tables::Error),
    /// Goal that cannot be read, or that no cell can have.
    #[error(transparent)]
    Goal(#[from] documents::Error),
    /// Table that states what no bake by this version states of the mesh.
    #[error("the table {0}")]
    Stated(String),
    /// Bake that the caller stopped.
    #[error("the bake was stopped before its end")]
    Stopped,
    /// Work that failed in another way.
    #[error("{0}")]
    Failed(String),
    /// Failure of another process, which prints it.
    #[error("another process failed")]
    Elsewhere,
}

impl Error {
    /// Makes the error of two options that exclude each other.
    pub(crate) fn both(first: &str, second: &str) -> Error {
        Error::Usage(format!(
            "{first} and {second} exclude each other; leave one of them out"
        ))
    }

    /// Returns the exit code of the program: 2 for wrong usage, 1 for work that failed.
    ///
    /// The code is 0 if another process failed. That process prints the failure, and its code is
    /// the code of the whole run.
    pub(crate) fn code(&self) -> u8 {
        match self {
            Error::Elsewhere => 0,
            Error::Usage(_) | Error::Table(tables::Error::PlotExtension(_)) => 2,
            // Faults of options that only the code of meshes can check.
            Error::Mesh(error) => match *error.fault {
                Fault::EdgeLength { .. }
                | Fault::EdgeLengthScale { .. }
                | Fault::AzimuthZero { .. } => 2,
                _ => 1,
            },
            _ => 1,
        }
    }
}
