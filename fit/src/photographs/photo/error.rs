//! Why a photograph cannot be used: each variant names the file, the place and the remedy.

use std::path::PathBuf;

use crate::photographs::photo::channel::Channel;
use crate::photographs::photo::format::Format;

/// A photograph that was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system does not give the file.
    #[error("{file}: cannot be read ({source}); check the path and its permissions")]
    Io {
        /// The photograph.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file of no bytes.
    #[error("{file}: is empty (0 bytes); copy the photograph again")]
    Empty {
        /// The photograph.
        file: PathBuf,
    },
    /// The first bytes belong to no format that is read.
    #[error(
        "{file}: is not an EXR, PNG, TIFF or JPEG file, whatever its name; export the photograph \
        as one of these"
    )]
    UnknownFormat {
        /// The photograph.
        file: PathBuf,
    },
    /// A camera raw file, in a program without the feature for it.
    #[error(
        "{file}: camera raw is not read by this build of fit; build it with the feature `raw` \
        (cargo install --path fit \
         --features raw), or develop the photograph without tone curve to a linear 16-bit TIFF or \
         an EXR"
    )]
    CameraRaw {
        /// The photograph.
        file: PathBuf,
    },
    /// Camera raw where a picture in colour is wanted.
    #[error(
        "{file}: is camera raw, which holds one colour a pixel; develop it without tone curve to \
        a linear 16-bit TIFF or \
         an EXR"
    )]
    Undeveloped {
        /// The photograph.
        file: PathBuf,
    },
    /// The decoder of camera raw gave up.
    #[error(
        "{file}: cannot be decoded as camera raw ({}); convert it to DNG, or develop it without \
        tone curve to a linear \
         16-bit TIFF or an EXR",
        one_line(reason)
    )]
    Raw {
        /// The photograph.
        file: PathBuf,
        /// What the decoder said.
        reason: String,
    },
    /// The header claims no pixels or too many.
    #[error(
        "{file}: its header claims {width} x {height} pixels, where 1 to {limit} in all are read; \
         crop or repair the file"
    )]
    Size {
        /// The photograph.
        file: PathBuf,
        /// Claimed columns.
        width: u64,
        /// Claimed rows.
        height: u64,
        /// Most pixels that are read.
        limit: u64,
    },
    /// Far more pixels than bytes.
    #[error(
        "{file}: claims {width} x {height} pixels in {bytes} bytes, as a decompression bomb does; \
        crop it, or save it \
         without compression"
    )]
    Packed {
        /// The photograph.
        file: PathBuf,
        /// Claimed columns.
        width: u64,
        /// Claimed rows.
        height: u64,
        /// Length of the file.
        bytes: u64,
    },
    /// The EXR decoder gave up.
    #[error(
        "{file}: cannot be decoded as EXR ({}); write or copy the file again",
        one_line(source)
    )]
    Exr {
        /// The photograph.
        file: PathBuf,
        /// What the decoder said.
        source: exr::error::Error,
    },
    /// The PNG, TIFF or JPEG decoder gave up.
    #[error("{file}: cannot be decoded as {} ({}); write or copy the file again", format.name(), one_line(source))]
    Raster {
        /// The photograph.
        file: PathBuf,
        /// Its format by signature.
        format: Format,
        /// What the decoder said.
        source: image::ImageError,
    },
    /// An EXR of deep samples, which have no one value per pixel.
    #[error("{file}: holds deep data; flatten it to one value per pixel")]
    Deep {
        /// The photograph.
        file: PathBuf,
    },
    /// An EXR channel at a lower resolution than the picture.
    #[error(
        "{file}: channel {channel} is subsampled; save the EXR as full-resolution R, G, B or Y"
    )]
    Subsampled {
        /// The photograph.
        file: PathBuf,
        /// Name of the channel.
        channel: String,
    },
    /// The plane asked for is not there.
    #[error("{file}: has no {wanted} channel; set `channel` to what it has: {}", found.join(", "))]
    NoChannel {
        /// The photograph.
        file: PathBuf,
        /// What was asked for.
        wanted: Channel,
        /// What the file has.
        found: Vec<String>,
    },
    /// Inks are not light.
    #[error(
        "{file}: is a CMYK picture; convert it to RGB or grey with the profile it was made with"
    )]
    Cmyk {
        /// The photograph.
        file: PathBuf,
    },
    /// A pixel that is NaN or infinite.
    #[error(
        "{file}: pixel (column {x}, row {y}) is {value}; repair or mask the photograph before the \
        fit"
    )]
    NotFinite {
        /// The photograph.
        file: PathBuf,
        /// Column of the first such pixel in reading order.
        x: usize,
        /// Row of it.
        y: usize,
        /// NaN or an infinity.
        value: f32,
    },
}

/// A decoder's own words in one line; some end theirs with a line break.
fn one_line(source: &impl ToString) -> String {
    source
        .to_string()
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
}
