//! Limits on the size of photographs, checked before memory is allocated.

use crate::photographs::photo::Fault;

/// Largest photograph that is decoded, pixels. A larger one is refused by its header alone.
pub(crate) const MAX_PIXELS: u64 = 200_000_000;

/// Longest file that is read into memory, bytes: the largest picture as four 16-bit channels.
pub(crate) const MAX_BYTES: u64 = MAX_PIXELS * 8;

/// Memory that all that stands before the pixels may take, bytes: the largest colour profiles have
/// some MiB.
pub(crate) const HEADER_BYTES: u64 = 64 << 20;

/// Memory that the pixels of any file may take, bytes.
const FREE: u64 = 256 << 20;

/// Memory that the pixels of a photograph may take, bytes: 150 megapixels of three 16-bit channels.
pub(crate) const MOST: u64 = 3 << 29;

/// Memory beyond [`FREE`] that the pixels may take, bytes per byte of the file. Noise can hardly be
/// packed; an edge without noise can be packed twentyfold.
const PACKED: u64 = 100;

/// Refuses pictures without pixels or with more than [`MAX_PIXELS`].
pub(crate) fn check_size(width: u64, height: u64) -> Result<(), Fault> {
    match width.checked_mul(height) {
        Some(1..=MAX_PIXELS) => Ok(()),
        _ => Err(Fault::Size(width, height)),
    }
}

/// Refuses pictures whose file of `length` bytes is far too short for the memory that the pixels
/// take. A pixel takes `bytes` in the decoder and four in the plane.
pub(crate) fn check_packed(
    [width, height]: [u64; 2],
    bytes: u64,
    length: u64,
) -> Result<(), Fault> {
    let pixels = width.saturating_mul(height);
    let needed = pixels.saturating_mul(bytes.saturating_add(4));
    if needed > FREE && needed > length.saturating_mul(PACKED) {
        return Err(Fault::Packed(width, height, length));
    }
    if needed > MOST {
        return Err(Fault::Heavy(width, height, needed));
    }
    Ok(())
}
