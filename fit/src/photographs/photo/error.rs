//! Errors of photographs. Each message names the file, the place and the remedy.

use std::path::PathBuf;

use crate::photographs::photo::channel::Channel;
use crate::photographs::photo::format::Format;

/// A reason why a photograph cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file that cannot be opened or read.
    #[error("{file}: cannot be read ({source}); check the path and its permissions")]
    Io {
        /// Path of the photograph.
        file: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A file without any bytes.
    #[error("{file}: is empty (0 bytes); copy the photograph again")]
    Empty {
        /// Path of the photograph.
        file: PathBuf,
    },
    /// A file whose first bytes belong to no supported format.
    #[error(
        "{file}: is not an EXR, PNG, TIFF or JPEG file, whatever its name; export the photograph \
        as one of these"
    )]
    UnknownFormat {
        /// Path of the photograph.
        file: PathBuf,
    },
    /// A camera raw file, in a program that was built without the feature `raw`.
    #[error(
        "{file}: camera raw is not read by this build of fit; build it with the feature `raw` \
        (cargo install --path fit --features raw), or develop the photograph without tone curve \
        to a linear 16-bit TIFF or an EXR"
    )]
    CameraRaw {
        /// Path of the photograph.
        file: PathBuf,
    },
    /// A camera raw file where a picture in colour is needed.
    #[error(
        "{file}: is camera raw, which holds one colour per pixel; develop it without tone curve \
        to a linear 16-bit TIFF or an EXR"
    )]
    Undeveloped {
        /// Path of the photograph.
        file: PathBuf,
    },
    /// A camera raw file that cannot be decoded.
    #[error(
        "{file}: cannot be decoded as camera raw ({}); convert it to DNG, or develop it without \
        tone curve to a linear 16-bit TIFF or an EXR",
        one_line(reason)
    )]
    Raw {
        /// Path of the photograph.
        file: PathBuf,
        /// The decoder's message.
        reason: String,
    },
    /// A header that claims no pixels, or too many.
    #[error(
        "{file}: its header claims {width} x {height} pixels, but fit reads 1 to {limit} pixels \
        in all; crop or repair the file"
    )]
    Size {
        /// Path of the photograph.
        file: PathBuf,
        /// Number of columns that the header claims.
        width: u64,
        /// Number of rows that the header claims.
        height: u64,
        /// Largest number of pixels that is read.
        limit: u64,
    },
    /// Picture whose pixels take more memory than any photograph may.
    #[error(
        "{}: has {width} x {height} pixels, which take {bytes} bytes in memory, above the limit of \
        {limit}; crop the photograph, or save fewer channels or bits",
        file.display()
    )]
    Heavy {
        /// Path of the photograph.
        file: PathBuf,
        /// Number of columns.
        width: u64,
        /// Number of rows.
        height: u64,
        /// Memory that the pixels take, bytes.
        bytes: u64,
        /// Greatest memory that is taken, bytes.
        limit: u64,
    },
    /// A header that claims far more pixels than the file has bytes for.
    #[error(
        "{file}: claims {width} x {height} pixels in {bytes} bytes, as a decompression bomb does; \
        crop it, or save it without compression"
    )]
    Packed {
        /// Path of the photograph.
        file: PathBuf,
        /// Number of columns that the header claims.
        width: u64,
        /// Number of rows that the header claims.
        height: u64,
        /// Length of the file, bytes.
        bytes: u64,
    },
    /// A file that cannot be decoded.
    #[error(
        "{}: cannot be decoded as {} ({}); copy the file again, or save it as {}",
        file.display(), format.name(), one_line(reason), format.best()
    )]
    Damaged {
        /// Path of the photograph.
        file: PathBuf,
        /// Format of the file by its first bytes.
        format: Format,
        /// The decoder's message.
        reason: String,
    },
    /// A file of a kind that is not read.
    #[error(
        "{}: holds {}, which fit does not read; save it as {}",
        file.display(), one_line(what), format.best()
    )]
    Unread {
        /// Path of the photograph.
        file: PathBuf,
        /// Format of the file by its first bytes.
        format: Format,
        /// The part that is not read, in words.
        what: String,
    },
    /// A JPEG, or a TIFF of JPEGs, that lacks a part of its data.
    #[error("{file}: is cut short or damaged ({reason}); copy the photograph again")]
    CutShort {
        /// Path of the photograph.
        file: PathBuf,
        /// Missing part, in words.
        reason: String,
    },
    /// A part of the file that names a transfer which cannot be followed.
    #[error(
        "{file}: its {part} cannot be followed ({reason}); convert the photograph to sRGB or to \
        linear light, or set `transfer` to linear or srgb"
    )]
    Tone {
        /// Path of the photograph.
        file: PathBuf,
        /// Name of the part.
        part: &'static str,
        /// Reason, in words.
        reason: String,
    },
    /// An EXR of deep samples, which have more than one value per pixel.
    #[error("{file}: holds deep data; flatten it to one value per pixel")]
    Deep {
        /// Path of the photograph.
        file: PathBuf,
    },
    /// A channel that the file does not have.
    #[error("{file}: has no {wanted} channel; set `channel` to what it has: {}", found.join(", "))]
    NoChannel {
        /// Path of the photograph.
        file: PathBuf,
        /// The channel that was asked for.
        wanted: Channel,
        /// Names of the channels that the file has.
        found: Vec<String>,
    },
    /// A picture in CMYK. Its values are inks, not light.
    #[error(
        "{file}: is a CMYK picture; convert it to RGB or grey with the profile it was made with"
    )]
    Cmyk {
        /// Path of the photograph.
        file: PathBuf,
    },
    /// A pixel that is NaN or infinite.
    #[error("{file}: pixel (column {x}, row {y}) is {value}; repair the picture there")]
    NotFinite {
        /// Path of the photograph.
        file: PathBuf,
        /// Column of the first such pixel in reading order, from 0.
        x: usize,
        /// Row of the first such pixel, from 0.
        y: usize,
        /// Value of the pixel: NaN or an infinity.
        value: f32,
    },
}

/// Returns a decoder's message in one line. Some decoders end theirs with a line break.
fn one_line(source: &impl ToString) -> String {
    source
        .to_string()
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
}
