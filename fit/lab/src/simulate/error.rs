//! Errors of simulated campaigns.

use std::path::PathBuf;

use edges::document;
use edges::names::Kernel;

/// A reason why a campaign cannot be simulated or written.
#[derive(Debug, thiserror::Error)]
#[allow(
    missing_docs,
    reason = "the message of a variant says what its fields are"
)]
#[non_exhaustive]
pub enum Error {
    /// A fault of the file of parameters or ranges.
    #[error(transparent)]
    Params(#[from] document::Error),
    /// A kernel or a lobe that the simulator does not have.
    #[error(
        "kernel {}: campaigns are simulated with the kernels and lobes of the proposed model; \
        name one of these",
        kernel.name()
    )]
    Unplanted { kernel: Kernel },
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
