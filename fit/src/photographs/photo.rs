//! Reading of photographs: a file of any supported format becomes one plane of linear light.
//!
//! What relates the values of a file to light is decided by the first of these that there is:
//! 1. the key or option `transfer`;
//! 2. for EXR: it is linear;
//! 3. what the file says of itself: the chunks cICP, iCCP, sRGB and gAMA of a PNG, in this order,
//!    the ICC profile of a TIFF or JPEG, or Adobe RGB in the Exif data of a JPEG;
//! 4. the default of the format: sRGB for 8 bits, linear for 16 bits and floats.
//!
//! Values of 8 bits cause a warning. What was taken stands in [`Photo::transfer`].
//!
//! The contents of a file decide its format, not its name. The only exception is camera raw (with
//! the feature `raw`), because much of it is TIFF inside. Row 0 is the top of the picture;
//! `x` runs along columns to the right, `y` along rows downward, as in the manifest.

mod caught;
pub(crate) mod channel;
mod chunks;
mod colour_space;
mod curve;
mod entropy;
pub(crate) mod error;
mod exif_data;
pub(crate) mod exposure;
pub(crate) mod format;
pub(crate) mod held;
mod icc;
mod jpeg;
pub(crate) mod limits;
mod openexr;
mod page;
mod pages;
pub(crate) mod picture;
pub(crate) mod plane;
mod raster;
#[cfg_attr(not(feature = "raw"), path = "photo/no_raw.rs")]
mod raw;
mod samples;
pub(crate) mod settings;
mod statement;
mod strips;
pub(crate) mod taken;
pub(crate) mod transfer;

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use crate::photographs::photo::caught::caught;
use crate::photographs::photo::channel::Decode;
use crate::photographs::photo::error::Error;
use crate::photographs::photo::format::{Format, extension, is_raw};
use crate::photographs::photo::picture::Picture;
use crate::photographs::photo::plane::Photo;
use crate::photographs::photo::transfer::Transfer;

/// Reads a photograph into linear light.
///
/// # Errors
/// Returns an `Error` if the file cannot be read or decoded, its format is unknown, its header
/// claims more than `MAX_PIXELS` pixels (checked before pixels are allocated), the channel does not
/// exist, or a pixel is not finite. So a [`Photo`] never holds NaN or infinity, except the NaN of
/// camera raw.
pub fn load(path: &Path, options: &Decode) -> Result<Photo, Error> {
    let Opened {
        format,
        reader,
        first,
        misnamed,
    } = open(path)?;
    if format == Format::Raw {
        return decoded(path, format, || raw::read(path, options));
    }
    let mut photo = decoded(path, format, || match format {
        Format::Exr => openexr::read(path, reader, &first, options),
        _ => raster::read(path, reader, format, options),
    })?;
    photo.warnings.splice(0..0, misnamed);
    check_finite(path, photo.width, &photo.luminance)?;
    Ok(photo)
}

/// Reads a picture in colour: red, green and blue, or one plane if the file has no colour. Alpha is
/// ignored. `transfer` has the meaning of [`Decode::transfer`].
///
/// # Errors
/// Returns an `Error` if the file cannot be read or decoded, its format is unknown or camera raw,
/// its header claims more than `MAX_PIXELS` pixels, or a pixel is not finite.
pub fn load_colour(path: &Path, transfer: Option<Transfer>) -> Result<Picture, Error> {
    let Opened {
        format,
        reader,
        first,
        misnamed,
    } = open(path)?;
    let mut picture = decoded(path, format, || match format {
        Format::Exr => openexr::read_colour(path, reader, &first),
        Format::Raw => Err(Error::Undeveloped {
            file: path.to_owned(),
        }),
        _ => raster::read_colour(path, reader, format, transfer),
    })?;
    picture.warnings.splice(0..0, misnamed);
    for plane in &picture.planes {
        check_finite(path, picture.width, plane)?;
    }
    Ok(picture)
}

/// Calls the decoder of a format. A panic of it is an error of the file.
fn decoded<T>(
    path: &Path,
    format: Format,
    decoder: impl FnOnce() -> Result<T, Error>,
) -> Result<T, Error> {
    caught(decoder).unwrap_or_else(|reason| {
        Err(Error::Damaged {
            file: path.to_owned(),
            format,
            reason,
        })
    })
}

/// A file whose format is known.
struct Opened {
    format: Format,
    reader: BufReader<File>,
    first: Vec<u8>,
    /// A warning if the file's name stands for another format.
    misnamed: Option<String>,
}

fn open(path: &Path) -> Result<Opened, Error> {
    let io = |source| Error::Io {
        file: path.to_owned(),
        source,
    };
    let mut file = crate::document::open(path).map_err(io)?;
    let mut first = Vec::with_capacity(16);
    file.by_ref().take(16).read_to_end(&mut first).map_err(io)?;
    if first.is_empty() {
        return Err(Error::Empty {
            file: path.to_owned(),
        });
    }
    let extension = extension(path);
    let format = if is_raw(&extension, &first) || pages::is_raw(&file) {
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
