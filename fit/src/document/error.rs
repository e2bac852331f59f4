//! What can be wrong with a TOML file, each with the line and what to do.

use std::path::PathBuf;

use crate::document::line::FileLine;
use crate::names::SpectrumError;

/// A TOML file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system does not give the file, or it is not text.
    #[error(
        "{file}: cannot be read ({source}); check the path, its permissions and that it is UTF-8 \
        text"
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
        place: FileLine,
        /// What the parser said.
        message: String,
    },
    /// A key that means nothing here.
    #[error("{place}: unknown key `{key}` in {section}; the nearest valid key is `{nearest}`")]
    UnknownKey {
        /// The line.
        place: FileLine,
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
        place: FileLine,
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
        place: FileLine,
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
        place: FileLine,
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
        place: FileLine,
        /// What is wrong with it.
        source: SpectrumError,
    },
    /// A key that has no default.
    #[error("{place}: `{key}` is missing from {section}; add it")]
    Missing {
        /// Where the table begins.
        place: FileLine,
        /// The key.
        key: &'static str,
        /// The table that lacks it.
        section: String,
    },
}
