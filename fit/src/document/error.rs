//! Errors of TOML files. Each message names the file and the line, and says what to do.

use std::path::PathBuf;

use crate::document::line::FileLine;
use crate::names::SpectrumError;

/// A reason why a TOML file cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file that cannot be opened or read, is not UTF-8 text, or is too long.
    #[error(
        "{file}: cannot be read ({source}); check the path, its permissions and that it is UTF-8 \
        text"
    )]
    Read {
        /// The file.
        file: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A text that is not valid TOML. A duplicate key is an error of this kind too.
    #[error("{place}: is not valid TOML ({message}); correct the line")]
    Syntax {
        /// Place of the first error.
        place: FileLine,
        /// The parser's message, in one line.
        message: String,
    },
    /// A key that its table may not have.
    #[error("{place}: unknown key `{key}` in {section}; the nearest valid key is `{nearest}`")]
    UnknownKey {
        /// Place of the key.
        place: FileLine,
        /// The unknown key.
        key: String,
        /// Name of the table that holds the key, for example `[[capture]]`.
        section: String,
        /// The valid key with the smallest edit distance to the unknown one.
        nearest: &'static str,
    },
    /// A key that is given by its old name and by its name of today.
    #[error("{place}: `{old}` is the old name of `{new}`, which is given too; remove one of them")]
    TwoNames {
        /// Place of the old name.
        place: FileLine,
        /// The old name.
        old: &'static str,
        /// The name of today.
        new: &'static str,
    },
    /// A value of the wrong type.
    #[error("{place}: `{key}` must be {expected}, not {found}; change the value")]
    WrongType {
        /// Place of the key.
        place: FileLine,
        /// The key that has the value.
        key: String,
        /// The type that the value must have, in words.
        expected: &'static str,
        /// The type that the value has, in words.
        found: &'static str,
    },
    /// A text that is none of the names that its key allows.
    #[error("{place}: `{key}` is \"{name}\", which means nothing; use one of {}", names.join(", "))]
    UnknownName {
        /// Place of the key.
        place: FileLine,
        /// The key that has the text.
        key: String,
        /// The text that was found.
        name: String,
        /// The names that the key allows.
        names: &'static [&'static str],
    },
    /// A number that is NaN, infinite or outside its range.
    #[error("{place}: `{key}` is {value} but must be {must_be}; correct the value")]
    OutOfRange {
        /// Place of the key.
        place: FileLine,
        /// The key that has the number.
        key: String,
        /// The number that was found.
        value: f64,
        /// The condition for the number in words, to follow "must be".
        must_be: &'static str,
    },
    /// A `wavelength_nm` that is not a spectrum.
    #[error("{place}: `wavelength_nm` {source}")]
    Spectrum {
        /// Place of the key `wavelength_nm`.
        place: FileLine,
        /// The fault of the spectrum.
        source: SpectrumError,
    },
    /// A key that is missing and has no default.
    #[error("{place}: `{key}` is missing from {section}; add it")]
    Missing {
        /// Place where the table begins.
        place: FileLine,
        /// The missing key.
        key: &'static str,
        /// Name of the table that lacks the key, for example `[[capture]]`.
        section: String,
    },
}
