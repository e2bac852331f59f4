//! Reasons why a file cannot be written.

use std::io;
use std::path::PathBuf;

/// Reason why a file cannot be written. Each message is one sentence that names the file and the
/// remedy.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// Path of a folder, a pipe or a device.
    #[error("{}: is not a regular file and cannot be replaced; name another file, or move it away", file.display())]
    NotAFile {
        /// Path that was asked for.
        file: PathBuf,
    },
    /// Name that other programs take for standard output.
    #[error(
        "-: is no name of a file here; name a file, such as result.json, or ./- for a file of this \
        name"
    )]
    Dash,
    /// Extension of another kind of file.
    #[error(
        "{}: is a table, but its name ends as that of another kind of file; name it .h5 or .hdf5",
        file.display()
    )]
    NotATable {
        /// Path that was asked for.
        file: PathBuf,
    },
    /// Symbolic link that leads to no file.
    #[error(
        "{}: is a link that leads nowhere; remove it, or choose another output",
        file.display()
    )]
    DeadLink {
        /// Path of the link.
        file: PathBuf,
    },
    /// Existing file that is write-protected.
    #[error("{}: is write-protected; choose another output or allow writing", file.display())]
    Protected {
        /// Path of the existing file.
        file: PathBuf,
    },
    /// Folder that cannot be written.
    #[error(
        "{}: cannot be written: its folder takes no file ({source}); choose another output, or \
        make the folder and allow writing",
        file.display()
    )]
    Folder {
        /// Path that was asked for.
        file: PathBuf,
        /// Message of the system.
        source: io::Error,
    },
    /// Writing that failed; an old file of that name is untouched.
    #[error(
        "{}: cannot be written ({source}), what was there before is unchanged; free some space or \
        choose another output",
        file.display()
    )]
    Write {
        /// Path of the file.
        file: PathBuf,
        /// Message of the system.
        source: io::Error,
    },
    /// Output that the same command reads.
    #[error(
        "{}: is an input of this command and would be overwritten; write to another file",
        file.display()
    )]
    Input {
        /// Path that was asked for.
        file: PathBuf,
    },
    /// Place that two outputs share.
    #[error(
        "{}: is named for two outputs of this command; give each a file of its own",
        file.display()
    )]
    Twice {
        /// Path that was asked for.
        file: PathBuf,
    },
}
