//! Photographs: any supported file to one plane of linear light.
//!
//! EXR (half, float, uint; linear), 16-bit PNG and TIFF (linear unless the manifest says otherwise), 8-bit PNG, TIFF
//! and JPEG (sRGB, linearised, with a warning). The type of a file is decided by its first bytes, never by its name, but for
//! camera raw (with the feature `raw`), much of which is TIFF inside.
//! Row 0 is the top of the picture; `x` runs along columns to the right, `y` along rows downward, as in the manifest.

mod error;
mod exposure;
mod openexr;
mod picture;
mod raster;
#[cfg_attr(not(feature = "raw"), path = "photo/no_raw.rs")]
mod raw;

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

pub use crate::photographs::photo::error::Error;
pub use crate::photographs::photo::exposure::Settings;
pub use crate::photographs::photo::picture::{Picture, Writing};

/// Largest photograph that is decoded, pixels: a claim beyond it is refused from the header alone.
pub const MAX_PIXELS: u64 = 200_000_000;

/// Rec. 709 weights of linear red, green and blue in luminance (ITU-R BT.709-6, item 3.2).
pub const REC709: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// How stored values relate to light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Transfer {
    /// Stored values are proportional to light.
    Linear,
    /// Stored values are sRGB-encoded (IEC 61966-2-1).
    Srgb,
}

impl Transfer {
    /// The names that a manifest may use, in the order of the variants.
    pub const NAMES: [&'static str; 2] = ["linear", "srgb"];

    /// The transfer called `name` in a manifest.
    pub fn from_name(name: &str) -> Option<Transfer> {
        match name {
            "linear" => Some(Transfer::Linear),
            "srgb" => Some(Transfer::Srgb),
            _ => None,
        }
    }

    /// Light of a stored value, both in units of full scale. sRGB is odd in the value, so noise around 0 stays centred.
    pub fn to_linear(self, stored: f32) -> f32 {
        match self {
            Transfer::Linear => stored,
            Transfer::Srgb => {
                let magnitude = stored.abs();
                let light = if magnitude <= 0.04045 {
                    magnitude / 12.92
                } else {
                    ((magnitude + 0.055) / 1.055).powf(2.4)
                };
                light.copysign(stored)
            }
        }
    }

    /// What is stored for a light: the inverse of [`Transfer::to_linear`].
    pub fn to_stored(self, light: f32) -> f32 {
        match self {
            Transfer::Linear => light,
            Transfer::Srgb => {
                let magnitude = light.abs();
                let stored = if magnitude <= 0.003_130_8 {
                    magnitude * 12.92
                } else {
                    1.055 * magnitude.powf(1.0 / 2.4) - 0.055
                };
                stored.copysign(light)
            }
        }
    }
}

/// Which plane of a colour photograph is used.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub enum Channel {
    /// Rec. 709 luminance of R, G, B, or the only plane of a monochrome file.
    #[default]
    Luminance,
    /// Linear red.
    Red,
    /// Linear green.
    Green,
    /// Linear blue.
    Blue,
    /// A channel of an EXR by its full name, such as `diffuse.R` or `L`.
    Named(String),
}

impl Channel {
    /// The primaries, in order.
    pub const PRIMARIES: [Channel; 3] = [Channel::Red, Channel::Green, Channel::Blue];

    /// The channel called `name` in a manifest: `luminance`, `red`, `green`, `blue` (or `r`, `g`, `b`), or any EXR channel name.
    pub fn from_name(name: &str) -> Channel {
        match name {
            "luminance" => Channel::Luminance,
            "r" | "red" => Channel::Red,
            "g" | "green" => Channel::Green,
            "b" | "blue" => Channel::Blue,
            other => Channel::Named(other.to_owned()),
        }
    }
}

impl std::fmt::Display for Channel {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Channel::Luminance => "luminance",
            Channel::Red => "red",
            Channel::Green => "green",
            Channel::Blue => "blue",
            Channel::Named(name) => name,
        })
    }
}

/// How a photograph is to be decoded.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct Decode {
    /// What stored values mean; `None`: linear for EXR, floats and 16-bit integers, sRGB for 8-bit integers.
    pub transfer: Option<Transfer>,
    /// Which plane is used.
    pub channel: Channel,
}

/// One plane of linear light.
#[derive(Debug, Clone, PartialEq)]
pub struct Photo {
    /// Columns, pixels.
    pub width: usize,
    /// Rows, pixels.
    pub height: usize,
    /// Linear light, row-major from the top left, `width * height` values. Integer formats: 1 is full scale. EXR: as stored.
    /// Finite, but for camera raw: NaN where the sensor saw another colour.
    pub luminance: Vec<f32>,
    /// Value from which a pixel counts as saturated: 1 for integer formats (a colour pixel with any saturated
    /// contributing channel is set to it), 65504 for half-float EXR. Other EXR has no limit of its own: 1 where
    /// the largest value is exactly 1, which a clipped, normalised sensor image has; else `None`.
    pub clip_level: Option<f32>,
    /// What was assumed or repaired, one sentence each, for the user.
    pub warnings: Vec<String>,
}

impl Photo {
    /// Value at column `x`, row `y`; `None` outside.
    pub fn at(&self, x: usize, y: usize) -> Option<f32> {
        if x < self.width {
            self.luminance.get(y * self.width + x).copied()
        } else {
            None
        }
    }

    /// Number of pixels at or above [`Photo::clip_level`]; 0 where the format has none.
    pub fn clipped(&self) -> usize {
        self.clip_level.map_or(0, |level| {
            self.luminance
                .iter()
                .filter(|&&value| value >= level)
                .count()
        })
    }
}

/// File types that are read, as found from the contents.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// OpenEXR.
    Exr,
    /// Portable Network Graphics.
    Png,
    /// Tagged Image File Format, also BigTIFF.
    Tiff,
    /// JPEG (JFIF or Exif).
    Jpeg,
    /// Any camera's raw file.
    Raw,
}

impl Format {
    /// The format that a file of these first bytes has.
    pub fn of_signature(first: &[u8]) -> Option<Format> {
        const SIGNATURES: [(&[u8], Format); 7] = [
            (&[0x76, 0x2f, 0x31, 0x01], Format::Exr),
            (b"\x89PNG\r\n\x1a\n", Format::Png),
            (&[0xff, 0xd8, 0xff], Format::Jpeg),
            (b"II*\0", Format::Tiff),
            (b"MM\0*", Format::Tiff),
            (b"II+\0", Format::Tiff),
            (b"MM\0+", Format::Tiff),
        ];
        SIGNATURES
            .iter()
            .find(|(signature, _)| first.starts_with(signature))
            .map(|&(_, format)| format)
    }

    /// Name for messages.
    pub const fn name(self) -> &'static str {
        match self {
            Format::Exr => "EXR",
            Format::Png => "PNG",
            Format::Tiff => "TIFF",
            Format::Jpeg => "JPEG",
            Format::Raw => "camera raw",
        }
    }

    const fn extensions(self) -> &'static [&'static str] {
        match self {
            Format::Exr => &["exr"],
            Format::Png => &["png"],
            Format::Tiff => &["tif", "tiff"],
            Format::Jpeg => &["jpg", "jpeg", "jpe"],
            Format::Raw => &CAMERA_RAW,
        }
    }
}

/// Extensions of camera raw files, many of which are TIFF inside and would yield their thumbnail.
const CAMERA_RAW: [&str; 20] = [
    "3fr", "arw", "cr2", "cr3", "crw", "dcr", "dng", "erf", "iiq", "kdc", "mef", "mos", "mrw",
    "nef", "nrw", "orf", "pef", "raf", "rw2", "srw",
];

/// Whether a file is camera raw by its name, or by its first bytes a CR2.
fn is_raw(extension: &str, first: &[u8]) -> bool {
    CAMERA_RAW.contains(&extension) || first.get(8..10) == Some(b"CR")
}

/// Said of a picture that was turned.
const TURNED: &str =
    "turned upright as its Exif orientation asks; x, y and `roi` refer to the upright picture";

/// Reads a photograph into linear light.
///
/// # Errors
/// One [`Error`] for each way in which the file cannot be used; non-finite pixels are an error, so a [`Photo`] never
/// holds NaN or infinity, but for the NaN of camera raw. Sizes beyond [`MAX_PIXELS`] are refused from the header, before pixels are allocated.
pub fn load(path: &Path, options: &Decode) -> Result<Photo, Error> {
    let Opened {
        format,
        reader,
        first,
        misnamed,
    } = open(path)?;
    let mut photo = match format {
        Format::Exr => openexr::read(path, reader, &first, options)?,
        Format::Png | Format::Tiff | Format::Jpeg => raster::read(path, reader, format, options)?,
        Format::Raw => return raw::read(path, options),
    };
    photo.warnings.splice(0..0, misnamed);
    check_finite(path, photo.width, &photo.luminance)?;
    Ok(photo)
}

/// Reads a picture in colour: red, green and blue, or one plane where the file has no colour. Alpha is ignored.
/// `transfer` as in [`Decode`].
///
/// # Errors
/// As [`load`].
pub fn load_colour(path: &Path, transfer: Option<Transfer>) -> Result<Picture, Error> {
    let Opened {
        format,
        reader,
        first,
        misnamed,
    } = open(path)?;
    let mut picture = match format {
        Format::Exr => openexr::read_colour(path, reader, &first)?,
        Format::Png | Format::Tiff | Format::Jpeg => {
            raster::read_colour(path, reader, format, transfer)?
        }
        Format::Raw => {
            return Err(Error::Undeveloped {
                file: path.to_owned(),
            });
        }
    };
    picture.warnings.splice(0..0, misnamed);
    for plane in &picture.planes {
        check_finite(path, picture.width, plane)?;
    }
    Ok(picture)
}

/// A file of a known format.
struct Opened {
    format: Format,
    reader: BufReader<File>,
    first: Vec<u8>,
    /// A warning where its name says something else.
    misnamed: Option<String>,
}

fn open(path: &Path) -> Result<Opened, Error> {
    let io = |source| Error::Io {
        file: path.to_owned(),
        source,
    };
    let mut file = File::open(path).map_err(io)?;
    let mut first = Vec::with_capacity(16);
    file.by_ref().take(16).read_to_end(&mut first).map_err(io)?;
    if first.is_empty() {
        return Err(Error::Empty {
            file: path.to_owned(),
        });
    }
    let extension = extension(path);
    let format = if is_raw(&extension, &first) {
        Format::Raw
    } else {
        Format::of_signature(&first).ok_or_else(|| Error::UnknownFormat {
            file: path.to_owned(),
        })?
    };
    file.seek(SeekFrom::Start(0)).map_err(io)?;
    let misnamed = format != Format::Raw
        && !extension.is_empty()
        && !format.extensions().contains(&extension.as_str());
    Ok(Opened {
        format,
        reader: BufReader::new(file),
        first,
        misnamed: misnamed.then(|| {
            format!(
                "{} holds {} data in spite of its name; it was read as such.",
                path.display(),
                format.name()
            )
        }),
    })
}

/// What a file's name ends in, in small letters.
fn extension(path: &Path) -> String {
    let extension = path.extension().and_then(|name| name.to_str());
    extension.unwrap_or("").to_ascii_lowercase()
}

fn check_finite(path: &Path, width: usize, plane: &[f32]) -> Result<(), Error> {
    match plane.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(Error::NotFinite {
            file: path.to_owned(),
            x: index % width,
            y: index / width,
            value: plane[index],
        }),
        None => Ok(()),
    }
}

/// Refuses sizes that no photograph has, before anything is allocated for them.
fn check_size(path: &Path, width: u64, height: u64) -> Result<(), Error> {
    match width.checked_mul(height) {
        Some(1..=MAX_PIXELS) => Ok(()),
        _ => Err(Error::Size {
            file: path.to_owned(),
            width,
            height,
            limit: MAX_PIXELS,
        }),
    }
}

/// Bytes of memory that the pixels of any file may take.
const FREE: u64 = 256 << 20;

/// Bytes above that, per byte of the file. Noise hardly packs; an edge without any, twentyfold.
const PACKED: u64 = 100;

/// Refuses pictures whose pixels would take `bytes` each in the decoder and four in the plane, where the file is far too
/// short to hold them.
fn check_packed(path: &Path, [width, height]: [u64; 2], bytes: u64) -> Result<(), Error> {
    let length = std::fs::metadata(path).map_or(0, |metadata| metadata.len());
    let needed = (width * height).saturating_mul(bytes.saturating_add(4));
    if needed > FREE && needed > length.saturating_mul(PACKED) {
        return Err(Error::Packed {
            file: path.to_owned(),
            width,
            height,
            bytes: length,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_meets_the_standard_at_known_codes() {
        // IEC 61966-2-1: 8-bit code and the linear light it stands for, to 6 digits.
        let known = [
            (0, 0.0),
            (10, 0.003_035_3),
            (11, 0.003_346_5),
            (128, 0.215_861),
            (188, 0.502_886),
            (255, 1.0),
        ];
        let mut cases = 0;
        for (code, light) in known {
            let found = Transfer::Srgb.to_linear(code as f32 / 255.0);
            assert!(
                (found - light).abs() <= 1e-6,
                "code {code}: {found} instead of {light}"
            );
            assert_eq!(Transfer::Srgb.to_linear(-(code as f32) / 255.0), -found);
            let code = code as f32 / 255.0;
            assert!((Transfer::Srgb.to_stored(found) - code).abs() < 1e-6);
            cases += 1;
        }
        assert_eq!(cases, 6);
    }

    #[test]
    fn names_round_trip() {
        for name in Transfer::NAMES {
            assert!(Transfer::from_name(name).is_some(), "{name}");
        }
        for name in ["luminance", "red", "green", "blue", "diffuse.R"] {
            assert_eq!(Channel::from_name(name).to_string(), name);
        }
    }
}
