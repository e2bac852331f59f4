//! Errors of a manifest. Each message names the file, the line, the key and the remedy.

use std::path::PathBuf;

use crate::document::FileLine;
use crate::document::error as document;
use crate::photographs::photo::error as photo;
use crate::photographs::photo::plane::as_shown;
use crate::photographs::roi::Roi;

/// A reason why a manifest cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A fault of the manifest's text, or of one of its keys.
    #[error(transparent)]
    Document(#[from] document::Error),
    /// An exposure that neither the manifest nor the photograph gives.
    #[error(
        "{place}: `exposure` is missing from [[capture]], and {} has {lack}; add `exposure`",
        image.display()
    )]
    NoExposure {
        place: FileLine,
        image: PathBuf,
        lack: String,
    },
    /// An image file that does not exist.
    #[error(
        "{place}: image {image} does not exist; paths are relative to the folder of the manifest"
    )]
    ImageMissing { place: FileLine, image: PathBuf },
    /// A key `expect_table` that is no content hash.
    #[error(
        "{place}: `expect_table` is \"{text}\", which is no content hash; write the 64 hex digits \
        that `bake verify` prints"
    )]
    NotAHash { place: FileLine, text: String },
    /// A manifest without any capture.
    #[error("{file}: has no [[capture]]; add one for each photograph of the mid-air image")]
    NoCaptures { file: PathBuf },
    /// A region that reaches beyond the picture.
    #[error(
        "{place}: {roi} reaches beyond {image}, which is {width} x {height} pixels{}; correct \
        `roi`",
        as_shown(*turned)
    )]
    RoiOutside {
        place: FileLine,
        roi: Roi,
        image: PathBuf,
        width: usize,
        height: usize,
        turned: bool,
    },
    /// A photograph that cannot be used.
    #[error(transparent)]
    Photo(#[from] photo::Error),
}
