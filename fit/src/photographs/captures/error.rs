//! Why a manifest cannot be used: each message names the file, the line, the key and the remedy.

use std::path::PathBuf;

use crate::photographs::captures::Roi;
use crate::photographs::captures::keys::Place;
use crate::photographs::captures::spectrum::SpectrumError;
use crate::photographs::photo;

/// A manifest that was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system does not give the file, or it is not text.
    #[error(
        "{file}: cannot be read ({source}); check the path, its permissions and that it is UTF-8 text"
    )]
    Read {
        /// The manifest.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Not TOML; also duplicate keys.
    #[error("{place}: is not valid TOML ({message}); correct the line")]
    Syntax {
        /// The line.
        place: Place,
        /// What the parser said.
        message: String,
    },
    /// A key that means nothing here.
    #[error("{place}: unknown key `{key}` in {section}; the nearest valid key is `{nearest}`")]
    UnknownKey {
        /// The line.
        place: Place,
        /// The key.
        key: String,
        /// The table that holds it.
        section: String,
        /// The valid key with the smallest edit distance.
        nearest: &'static str,
    },
    /// A value of another type.
    #[error("{place}: `{key}` must be {expected}, not {found}; change the value")]
    WrongType {
        /// The line.
        place: Place,
        /// The key.
        key: String,
        /// What it must be.
        expected: &'static str,
        /// What it is.
        found: &'static str,
    },
    /// A name that stands for nothing.
    #[error("{place}: `{key}` is \"{name}\", which means nothing; use one of {}", names.join(", "))]
    UnknownName {
        /// The line.
        place: Place,
        /// The key.
        key: String,
        /// Its value.
        name: String,
        /// The names that it may have.
        names: &'static [&'static str],
    },
    /// A number outside its range, or none at all.
    #[error("{place}: `{key}` is {value} but must be {must_be}; correct the value")]
    OutOfRange {
        /// The line.
        place: Place,
        /// The key.
        key: String,
        /// Its value.
        value: f64,
        /// The condition in words.
        must_be: &'static str,
    },
    /// A spectrum that cannot be read.
    #[error("{place}: `wavelength_nm` {source}")]
    Spectrum {
        /// The line.
        place: Place,
        /// What is wrong with it.
        source: SpectrumError,
    },
    /// A key that has no default.
    #[error("{place}: `{key}` is missing from {section}; add it")]
    Missing {
        /// Where the table begins.
        place: Place,
        /// The key.
        key: &'static str,
        /// The table that lacks it.
        section: String,
    },
    /// Neither the manifest nor the photograph tells the exposure.
    #[error("{place}: `exposure` is missing from [[capture]], and {} has {lack}; add `exposure`", image.display())]
    NoExposure {
        /// Where the capture begins.
        place: Place,
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
        place: Place,
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
        place: Place,
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
