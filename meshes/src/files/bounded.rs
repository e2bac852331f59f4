//! Bounds of what is read: the size of a file, and numbers of elements.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::mesh::error::Fault;
use crate::mesh::mesh::MAX_ELEMENTS;

/// Largest file, and most bytes of all buffers of a mesh.
///
/// Sheets of thousands of cells take some MiB. With [`MAX_ELEMENTS`] it keeps the memory of a mesh
/// below 1 GiB.
pub(crate) const MAX_BYTES: u64 = 1 << 27;

/// Checks that a number of elements is at most [`MAX_ELEMENTS`], before anything of its size is
/// allocated.
pub(crate) fn within(what: &'static str, found: usize) -> Result<(), Fault> {
    let (found, limit) = (found as u64, MAX_ELEMENTS as u64);
    match found > limit {
        true => Err(Fault::TooLarge { what, found, limit }),
        false => Ok(()),
    }
}

/// Reads a regular file of at most `limit` bytes.
///
/// A pipe would wait for its writer, and a device may never end. The size is checked before and
/// while reading, because the file may grow.
pub(crate) fn read_bounded(path: &Path, limit: u64) -> Result<Vec<u8>, Fault> {
    let regular = |metadata: &std::fs::Metadata| match metadata.is_file() {
        true => Ok(()),
        false => Err(Fault::NotAFile),
    };
    // Opening a pipe would wait already.
    regular(&std::fs::metadata(path).map_err(Fault::Unreadable)?)?;
    let file = File::open(path).map_err(Fault::Unreadable)?;
    let metadata = file.metadata().map_err(Fault::Unreadable)?;
    regular(&metadata)?;
    if metadata.len() > limit {
        return Err(Fault::TooLarge {
            what: "bytes",
            found: metadata.len(),
            limit,
        });
    }
    let mut bytes = Vec::new();
    file.take(limit + 1)
        .read_to_end(&mut bytes)
        .map_err(Fault::Unreadable)?;
    if bytes.len() as u64 > limit {
        return Err(Fault::TooLarge {
            what: "bytes",
            found: bytes.len() as u64,
            limit,
        });
    }
    Ok(bytes)
}
