//! Why a manifest cannot be used: each message names the file, the line, the key and the remedy.

use std::path::PathBuf;

use crate::document::FileLine;
use crate::document::error as document;
use crate::photographs::photo::error as photo;
use crate::photographs::roi::Roi;

/// A manifest that was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The manifest's text, or a key of it.
    #[error(transparent)]
    Document(#[from] document::Error),
    /// Neither the manifest nor the photograph tells the exposure.
    #[error("{place}: `exposure` is missing from [[capture]], and {} has {lack}; add `exposure`", image.display())]
    NoExposure {
        /// Where the capture begins.
        place: FileLine,
        /// The photograph that lacks it.
        image: PathBuf,
        /// What it lacks.
        lack: String,
    },
    /// An image that is not there.
    #[error(
        "{place}: image {image} does not exist; paths are relative to the folder of the manifest"
    )]
    ImageMissing {
        /// The line that names it.
        place: FileLine,
        /// The path looked for.
        image: PathBuf,
    },
    /// Nothing to fit.
    #[error("{file}: has no [[capture]]; add one for each photograph of the mid-air image")]
    NoCaptures {
        /// The manifest.
        file: PathBuf,
    },
    /// A region beyond the picture.
    #[error(
        "{place}: {roi} reaches beyond {image}, which is {width} x {height} pixels; correct `roi`"
    )]
    RoiOutside {
        /// The line that names the photograph.
        place: FileLine,
        /// The region.
        roi: Roi,
        /// The photograph.
        image: PathBuf,
        /// Columns of the photograph.
        width: usize,
        /// Rows of the photograph.
        height: usize,
    },
    /// The photograph itself cannot be used.
    #[error(transparent)]
    Photo(#[from] photo::Error),
}
