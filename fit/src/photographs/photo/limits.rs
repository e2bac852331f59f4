//! Limits on the size of photographs, checked before memory is allocated.

use std::path::Path;

use crate::photographs::photo::error::Error;

/// Largest photograph that is decoded, pixels. A larger one is refused by its header alone.
pub(crate) const MAX_PIXELS: u64 = 200_000_000;

/// Memory that a decoder may allocate, bytes: that of the largest picture as four 16-bit channels.
pub(crate) const MAX_BYTES: u64 = MAX_PIXELS * 8;

/// Memory that all that stands before the pixels may take, bytes: the largest colour profiles have
/// some MiB.
pub(crate) const HEADER_BYTES: u64 = 64 << 20;

/// Refuses pictures without pixels or with more than [`MAX_PIXELS`].
pub(crate) fn check_size(path: &Path, width: u64, height: u64) -> Result<(), Error> {
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

/// Memory that the pixels of any file may take, bytes.
const FREE: u64 = 256 << 20;

/// Memory that the pixels of a photograph may take, bytes: 150 megapixels of three 16-bit channels.
const MOST: u64 = 3 << 29;

/// Memory beyond [`FREE`] that the pixels may take, bytes per byte of the file. Noise can hardly be
/// packed; an edge without noise can be packed twentyfold.
const PACKED: u64 = 100;

/// Refuses pictures whose file is far too short for the memory that the pixels take. A pixel takes
/// `bytes` in the decoder and four in the plane.
pub(crate) fn check_packed(
    path: &Path,
    [width, height]: [u64; 2],
    bytes: u64,
) -> Result<(), Error> {
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
    if needed > MOST {
        return Err(Error::Heavy {
            file: path.to_owned(),
            width,
            height,
            bytes: needed,
            limit: MOST,
        });
    }
    Ok(())
}
