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

pub mod channel;
mod curve;
pub mod error;
pub mod exif;
pub mod format;
mod formats;
pub mod in_memory;
pub(crate) mod limits;
pub mod picture;
pub mod plane;
mod raster;
mod samples;
pub mod taken;
pub mod transfer;

use std::cell::Cell;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::path::Path;
use std::sync::Once;

use crate::photographs::photo::channel::{Channel, Decode, REC709};
use crate::photographs::photo::curve::Curve;
use crate::photographs::photo::error::{Error, Fault};
use crate::photographs::photo::exif::Settings;
use crate::photographs::photo::format::{Format, extension, is_raw};
use crate::photographs::photo::formats::{openexr, pages, raw};
use crate::photographs::photo::limits::{check_packed, check_size};
use crate::photographs::photo::picture::Picture;
use crate::photographs::photo::plane::{Photo, TURNED};
use crate::photographs::photo::raster::Decoded;
use crate::photographs::photo::samples::{Alpha, Samples, Stored, upright};
use crate::photographs::photo::taken::{Curves, GIVEN, Taken};
use crate::photographs::photo::transfer::Transfer;

/// Reads a photograph into linear light.
///
/// # Errors
/// Returns an `Error` if the file cannot be read or decoded, its format is unknown, its header
/// claims more than `MAX_PIXELS` pixels (checked before pixels are allocated), the channel does not
/// exist, or a pixel is not finite. So a [`Photo`] never holds NaN or infinity, except the NaN of
/// camera raw.
pub fn load(path: &Path, options: &Decode) -> Result<Photo, Error> {
    let read = || -> Result<Photo, Fault> {
        let opened = open(path)?;
        let (format, reader) = (opened.format, opened.reader);
        let mut photo = decoded(format, || match format {
            Format::Raw => raw::read(path, options),
            Format::Exr => openexr::read(reader, &opened.first, options),
            _ => raster::read(reader, format, options),
        })?;
        photo.warnings.splice(0..0, opened.misnamed);
        if format != Format::Raw {
            check_finite(photo.width, &photo.luminance)?;
        }
        Ok(photo)
    };
    read().map_err(|fault| fault.of(path))
}

/// Reads a picture in colour: red, green and blue, or one plane if the file has no colour. Alpha is
/// ignored. `transfer` has the meaning of [`Decode::transfer`].
///
/// # Errors
/// Returns an `Error` if the file cannot be read or decoded, its format is unknown or camera raw,
/// its header claims more than `MAX_PIXELS` pixels, or a pixel is not finite.
pub fn load_colour(path: &Path, transfer: Option<Transfer>) -> Result<Picture, Error> {
    let read = || -> Result<Picture, Fault> {
        let opened = open(path)?;
        let (format, reader) = (opened.format, opened.reader);
        let mut picture = decoded(format, || match format {
            Format::Exr => openexr::read_colour(reader, &opened.first),
            Format::Raw => Err(Fault::Raw(
                "is camera raw, which holds one colour per pixel;".into(),
            )),
            _ => raster::read_colour(reader, format, transfer),
        })?;
        picture.warnings.splice(0..0, opened.misnamed);
        for plane in &picture.planes {
            check_finite(picture.width, plane)?;
        }
        Ok(picture)
    };
    read().map_err(|fault| fault.of(path))
}

/// Calls the decoder of a format. A panic of it is an error of the file.
fn decoded<T>(format: Format, decoder: impl FnOnce() -> Result<T, Fault>) -> Result<T, Fault> {
    caught(decoder).unwrap_or_else(|reason| Err(Fault::Damaged(format, reason)))
}

/// A file whose format is known.
struct Opened {
    format: Format,
    reader: BufReader<File>,
    first: Vec<u8>,
    /// A warning if the file's name stands for another format.
    misnamed: Option<String>,
}

fn open(path: &Path) -> Result<Opened, Fault> {
    let mut file = crate::document::open(path)?;
    let mut first = Vec::with_capacity(16);
    file.by_ref().take(16).read_to_end(&mut first)?;
    if first.is_empty() {
        return Err(Fault::Empty);
    }
    let extension = extension(path);
    let format = if is_raw(&extension, &first) || pages::is_raw(&file) {
        Format::Raw
    } else {
        Format::of_signature(&first).ok_or(Fault::UnknownFormat)?
    };
    file.seek(SeekFrom::Start(0))?;
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

fn check_finite(width: usize, plane: &[f32]) -> Result<(), Fault> {
    match plane.iter().position(|value| !value.is_finite()) {
        Some(i) => Err(Fault::NotFinite(i % width, i / width, plane[i])),
        None => Ok(()),
    }
}

thread_local! {
    /// True while this thread is within a decoder.
    static IS_DECODING: Cell<bool> = const { Cell::new(false) };
}

/// Calls a decoder: the border where a panic of it becomes an error. It prints nothing.
///
/// # Errors
/// Returns the message of a panic.
pub(crate) fn caught<T>(decoder: impl FnOnce() -> T) -> Result<T, String> {
    static QUIET: Once = Once::new();
    QUIET.call_once(|| {
        let print = take_hook();
        set_hook(Box::new(move |panic| {
            if !IS_DECODING.get() {
                print(panic);
            }
        }));
    });
    let before = IS_DECODING.replace(true);
    // What the decoder held is lost with it.
    let result = catch_unwind(AssertUnwindSafe(decoder));
    IS_DECODING.set(before);
    result.map_err(|panic| {
        let text = panic.downcast_ref::<&str>().copied();
        let text = text.or(panic.downcast_ref::<String>().map(String::as_str));
        format!("its decoder failed: {}", text.unwrap_or("no reason given"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A panic ends at the border with its message, also one in a decoder within another and in
    /// threads of rayon. What comes after it is whole.
    #[test]
    fn a_panic_ends_at_the_border() {
        use rayon::prelude::*;
        let words = ["one", "two"];
        let at = std::hint::black_box(words.len());
        let panics: [Result<&str, String>; 3] = [
            caught(|| words[at]),
            caught(|| caught(|| words[at]).unwrap_or("inner")),
            caught(|| {
                (0..9)
                    .into_par_iter()
                    .map(|i| words[i])
                    .max()
                    .unwrap_or("none")
            }),
        ];
        let told = |result: &Result<&str, String>| match result {
            Ok(word) => (*word).to_owned(),
            Err(text) => text.chars().take(40).collect(),
        };
        let told = panics.each_ref().map(told);
        assert_eq!(told[0], "its decoder failed: index out of bounds:");
        assert_eq!(told[1], "inner");
        assert!(told[2].starts_with("its decoder failed"), "{}", told[2]);
        assert_eq!(caught(|| words[1]), Ok("two"));
        assert!(!IS_DECODING.get());
    }
}
