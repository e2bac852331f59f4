//! Errors of simulated campaigns.

use std::path::PathBuf;

use crate::document::FileLine;
use crate::document::error as document;
use crate::names::Kernel;

/// A reason why a campaign cannot be simulated or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A fault of the parameter file.
    #[error(transparent)]
    Params(#[from] document::Error),
    /// A parameter file without any capture.
    #[error("{file}: has no [[capture]]; add one for each photograph of the mid-air image")]
    NoCaptures {
        /// Path of the parameter file.
        file: PathBuf,
    },
    /// A table by incidence without an entry for the incidence of a capture.
    #[error(
        "{place}: incidence {incidence_deg} has no entry in the table `{key}` of [truth]; add it"
    )]
    NoEntry {
        /// Place where the capture begins.
        place: FileLine,
        /// The key of the table: `a` or `mu`.
        key: &'static str,
        /// Incidence of the capture, degrees.
        incidence_deg: f64,
    },
    /// An entry of a table by incidence whose name is not an angle.
    #[error(
        "{place}: `{name}` in the table `{key}` is not an incidence in degrees; write it as \
        \"15\" or \"22.5\""
    )]
    EntryName {
        /// Line of the table.
        place: FileLine,
        /// The key of the table: `a` or `mu`.
        key: &'static str,
        /// Name of the entry.
        name: String,
    },
    /// A kernel or a lobe that the simulator does not have.
    #[error(
        "kernel {}: campaigns are simulated with the kernels and lobes of the proposed model; \
        name one of these",
        kernel.name()
    )]
    Unplanted {
        /// The kernel that was asked for.
        kernel: Kernel,
    },
    /// A range that ends before it starts.
    #[error("{place}: `{key}` goes from {from} to {to}; write the smaller number under `from`")]
    Range {
        /// Line of the range.
        place: FileLine,
        /// The key of the range.
        key: &'static str,
        /// Start of the range.
        from: f64,
        /// End of the range.
        to: f64,
    },
    /// A sheet that cannot be photographed.
    #[error("the sheet of the table: {why}")]
    Sheet {
        /// The reason, and what to do.
        why: String,
    },
    /// An output folder that is not empty.
    #[error(
        "{folder}: is not empty; name another folder or add --force to overwrite the files of a \
        campaign in it"
    )]
    NotEmpty {
        /// Path of the folder.
        folder: PathBuf,
    },
    /// A file or folder that cannot be written.
    #[error(
        "{file}: cannot be written ({source}); check the path, its permissions and the space left"
    )]
    Write {
        /// Path of the file or folder.
        file: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A photograph that cannot be written.
    #[error(
        "{file}: cannot be written ({source}); check the path, its permissions and the space left"
    )]
    WriteExr {
        /// Path of the photograph.
        file: PathBuf,
        /// The encoder's error.
        source: exr::error::Error,
    },
    /// A photograph that cannot be packed as JPEG.
    #[error("a photograph cannot be packed as JPEG ({source}); make it smaller")]
    Jpeg {
        /// The encoder's or decoder's error.
        #[from]
        source: image::ImageError,
    },
}
