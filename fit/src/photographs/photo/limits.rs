//! Photographs that are refused before anything is allocated for them.

use std::path::Path;

use crate::photographs::photo::error::Error;

/// Largest photograph that is decoded, pixels: a claim beyond it is refused from the header alone.
pub(crate) const MAX_PIXELS: u64 = 200_000_000;

/// Refuses sizes that no photograph has, before anything is allocated for them.
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

/// Bytes of memory that the pixels of any file may take.
const FREE: u64 = 256 << 20;

/// Bytes above that, per byte of the file. Noise hardly packs; an edge without any, twentyfold.
const PACKED: u64 = 100;

/// Refuses pictures whose pixels would take `bytes` each in the decoder and four in the plane,
/// where the file is far too short to hold them.
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
    Ok(())
}
