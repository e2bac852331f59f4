//! Why something that both command lines do failed.

use std::path::PathBuf;

use crate::cli::threads::NoThreads;
use crate::error::output::OutputError;

/// Why something that both command lines do failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Standard output is full or gone. A closed pipe is no error: its reader has seen enough.
    #[error(
        "standard output cannot be written ({0}); check the pipe, free some space, or use -o \
        where the verb has it"
    )]
    Stdout(std::io::Error),
    /// A file cannot be reserved or written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A folder cannot be made.
    #[error("{}: the folder cannot be made ({source}); name one that can", folder.display())]
    Folder {
        /// The folder asked for.
        folder: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A plot of no known format.
    #[error("{}: the extension must be .png or .svg", .0.display())]
    PlotExtension(PathBuf),
    /// Threads could not be started.
    #[error(transparent)]
    Threads(#[from] NoThreads),
}
