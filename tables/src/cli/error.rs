//! Errors of what both command lines do: print, write files, start threads.

use std::path::PathBuf;

use crate::cli::threads::NoThreads;
use crate::error::output::OutputError;

/// Error of something that both command lines do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Standard output that cannot be written.
    ///
    /// A closed pipe is no error: its reader has seen enough.
    #[error(
        "standard output cannot be written ({0}); check the pipe, free some space, or use -o \
        where the verb has it"
    )]
    Stdout(std::io::Error),
    /// File that cannot be reserved or written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Folder that cannot be made.
    #[error("{}: the folder cannot be made ({source}); name a folder that can", folder.display())]
    Folder {
        /// Folder that was asked for.
        folder: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// File of a plot whose extension names no known format.
    #[error("{}: the extension must be .svg; browsers show and print SVG, and Inkscape makes PNG or \
        PDF of it", .0.display())]
    PlotExtension(PathBuf),
    /// Threads that could not be started.
    #[error(transparent)]
    Threads(#[from] NoThreads),
}
