//! Why a file cannot be written.

use std::io;
use std::path::PathBuf;

/// Why a file cannot be written. Each message is one sentence that names the file and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The path names a folder, a pipe or a device.
    #[error("{}: is not a regular file and cannot be replaced; name a file", file.display())]
    NotAFile {
        /// The path asked for.
        file: PathBuf,
    },
    /// The file that would be replaced is write-protected.
    #[error("{}: is write-protected; choose another output or allow writing", file.display())]
    Protected {
        /// The existing file.
        file: PathBuf,
    },
    /// The folder cannot be written.
    #[error(
        "{}: cannot be written: its folder takes no file ({source}); choose another output, or \
        make the folder \
         and allow writing",
        file.display()
    )]
    Folder {
        /// The path asked for.
        file: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// Writing failed; an old file of that name is untouched.
    #[error(
        "{}: cannot be written ({source}), what was there before is unchanged; free some space or \
        choose \
         another output",
        file.display()
    )]
    Write {
        /// The file to be written.
        file: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The same command reads the file.
    #[error("{}: is an input of this command and would be overwritten; write to another file", file.display())]
    Input {
        /// The path asked for.
        file: PathBuf,
    },
    /// Two outputs have one place.
    #[error("{}: is named for two outputs of this command; give each a file of its own", file.display())]
    Twice {
        /// The path asked for.
        file: PathBuf,
    },
}
