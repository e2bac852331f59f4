//! Errors of photographs. Each message names the file, the place and the remedy.

use std::path::{Path, PathBuf};

use crate::photographs::photo::limits::{MAX_PIXELS, MOST};
use crate::photographs::photo::{Channel, Format};

/// A photograph that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{}: {fault}", file.display())]
pub struct Error {
    /// Path of the photograph.
    pub file: PathBuf,
    /// Reason and remedy.
    pub fault: Fault,
}

/// A reason why a photograph cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// A file that cannot be opened or read.
    #[error("cannot be read ({0}); check the path and its permissions")]
    Io(#[from] std::io::Error),
    /// A file without any bytes.
    #[error("is empty (0 bytes); copy the photograph again")]
    Empty,
    /// A file whose first bytes belong to no supported format.
    #[error(
        "is not an EXR, PNG, TIFF or JPEG file, whatever its name; export the photograph as one \
        of these"
    )]
    UnknownFormat,
    /// A camera raw file that is not read here, and why.
    #[error("{0} develop the photograph without tone curve to a linear 16-bit TIFF or an EXR")]
    Raw(String),
    /// A header that claims no pixels, or too many: columns and rows.
    #[error(
        "its header claims {0} x {1} pixels, but fit reads 1 to {MAX_PIXELS} pixels in all; crop \
        or repair the file"
    )]
    Size(u64, u64),
    /// Pixels that take more memory than any photograph may: columns, rows, bytes.
    #[error(
        "has {0} x {1} pixels, which take {2} bytes in memory, above the limit of {MOST}; crop \
        the photograph, or save fewer channels or bits"
    )]
    Heavy(u64, u64, u64),
    /// A header that claims far more pixels than the file has bytes for: columns, rows, bytes.
    #[error(
        "claims {0} x {1} pixels in {2} bytes, as a decompression bomb does; crop it, or save it \
        without compression"
    )]
    Packed(u64, u64, u64),
    /// A file that cannot be decoded, with the decoder's message.
    #[error(
        "cannot be decoded as {} ({}); copy the file again, or save it as {}",
        .0.name(), one_line(.1), .0.best()
    )]
    Damaged(Format, String),
    /// A file with a part, in words, of a kind that is not read.
    #[error("holds {}, which fit does not read; save it as {}", one_line(.1), .0.best())]
    Unread(Format, String),
    /// A JPEG, or a TIFF of JPEGs, that lacks a part of its data, in words.
    #[error("is cut short or damaged ({}); copy the photograph again", one_line(.0))]
    CutShort(String),
    /// A part of the file that names a transfer which cannot be followed, and why.
    #[error(
        "its {0} cannot be followed ({1}); convert the photograph to sRGB or to linear light, or \
        set `transfer` to linear or srgb"
    )]
    Tone(&'static str, String),
    /// An EXR of deep samples, which have more than one value per pixel.
    #[error("holds deep data; flatten it to one value per pixel")]
    Deep,
    /// A channel that the file does not have, and those that it has.
    #[error("has no {0} channel; set `channel` to what it has: {found}", found = .1.join(", "))]
    NoChannel(Channel, Vec<String>),
    /// A picture in CMYK. Its values are inks, not light.
    #[error("is a CMYK picture; convert it to RGB or grey with the profile it was made with")]
    Cmyk,
    /// A pixel that is NaN or infinite: column, row and value of the first one.
    #[error("pixel (column {0}, row {1}) is {2}; repair the picture there")]
    NotFinite(usize, usize, f32),
}

impl Fault {
    /// Names the file.
    pub(crate) fn of(self, file: &Path) -> Error {
        Error {
            file: file.to_owned(),
            fault: self,
        }
    }
}

/// Returns a decoder's message in one line. Some decoders end theirs with a line break.
pub(crate) fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}
