//! Why a campaign cannot be simulated.

use std::path::PathBuf;

use crate::document::FileLine;
use crate::document::error as document;
use crate::names::Kernel;

/// A simulation that was refused or could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The parameter file is wrong.
    #[error(transparent)]
    Params(#[from] document::Error),
    /// Nothing to photograph.
    #[error("{file}: has no [[capture]]; add one for each photograph of the mid-air image")]
    NoCaptures {
        /// The parameter file.
        file: PathBuf,
    },
    /// A table by incidence lacks the incidence of a capture.
    #[error(
        "{place}: incidence {incidence_deg} has no entry in the table `{key}` of [truth]; add it"
    )]
    NoEntry {
        /// Line of the capture.
        place: FileLine,
        /// `a` or `mu`.
        key: &'static str,
        /// Incidence of the capture, degrees.
        incidence_deg: f64,
    },
    /// An entry of such a table is not under an angle.
    #[error(
        "{place}: `{name}` in the table `{key}` is not an incidence in degrees; write it as \
        \"15\" or \"22.5\""
    )]
    EntryName {
        /// Line of the table.
        place: FileLine,
        /// `a` or `mu`.
        key: &'static str,
        /// The name.
        name: String,
    },
    /// A model that the simulator does not photograph.
    #[error("kernel {}: campaigns are simulated with the kernels and lobes of the proposed model; \
    name one of these", kernel.name())]
    Unplanted {
        /// Its kernel.
        kernel: Kernel,
    },
    /// A range that ends before it starts.
    #[error("{place}: `{key}` goes from {from} to {to}; write the smaller number under `from`")]
    Range {
        /// Line of the range.
        place: FileLine,
        /// Its key.
        key: &'static str,
        /// Where it starts.
        from: f64,
        /// Where it ends.
        to: f64,
    },
    /// A sheet that cannot be photographed.
    #[error("the sheet of the table: {why}")]
    Sheet {
        /// Why, and what to do.
        why: String,
    },
    /// The folder holds something.
    #[error(
        "{folder}: is not empty; name another folder or add --force to overwrite the files of a \
        campaign in it"
    )]
    NotEmpty {
        /// The folder.
        folder: PathBuf,
    },
    /// A file or folder cannot be written.
    #[error(
        "{file}: cannot be written ({source}); check the path, its permissions and the space left"
    )]
    Write {
        /// The file or folder.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A photograph cannot be written.
    #[error(
        "{file}: cannot be written ({source}); check the path, its permissions and the space left"
    )]
    WriteExr {
        /// The file.
        file: PathBuf,
        /// What the encoder said.
        source: exr::error::Error,
    },
}
