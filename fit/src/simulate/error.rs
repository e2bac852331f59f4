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
    NoCaptures { file: PathBuf },
    /// A table by incidence without an entry for the incidence of a capture.
    #[error(
        "{place}: incidence {incidence_deg} has no entry in the table `{key}` of [truth]; add it"
    )]
    NoEntry {
        place: FileLine,
        key: &'static str,
        incidence_deg: f64,
    },
    /// An entry of a table by incidence whose name is not an angle.
    #[error(
        "{place}: `{name}` in the table `{key}` is not an incidence in degrees; write it as \
        \"15\" or \"22.5\""
    )]
    EntryName {
        place: FileLine,
        key: &'static str,
        name: String,
    },
    /// A kernel or a lobe that the simulator does not have.
    #[error(
        "kernel {}: campaigns are simulated with the kernels and lobes of the proposed model; \
        name one of these",
        kernel.name()
    )]
    Unplanted { kernel: Kernel },
    /// A range that ends before it starts.
    #[error("{place}: `{key}` goes from {from} to {to}; write the smaller number under `from`")]
    Range {
        place: FileLine,
        key: &'static str,
        from: f64,
        to: f64,
    },
    /// A sheet that cannot be photographed.
    #[error("the sheet of the table: {why}")]
    Sheet { why: String },
    /// An output folder that is not empty.
    #[error(
        "{folder}: is not empty; name another folder or add --force to overwrite the files of a \
        campaign in it"
    )]
    NotEmpty { folder: PathBuf },
    /// A file, folder or photograph that cannot be written.
    #[error(
        "{file}: cannot be written ({source}); check the path, its permissions and the space left"
    )]
    Write {
        file: PathBuf,
        source: std::io::Error,
    },
    /// A photograph that cannot be packed as JPEG.
    #[error("a photograph cannot be packed as JPEG ({source}); make it smaller")]
    Jpeg {
        #[from]
        source: image::ImageError,
    },
}
