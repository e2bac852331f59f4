//! Reading of a file of a bounded size.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::mesh::error::{Counted, Fault};

/// Largest file or buffer that is read, bytes.
pub(crate) const MAX_BYTES: u64 = 1 << 29;

/// Reads a file of at most `limit` bytes.
///
/// The size is checked before and while reading, because the file may be a pipe.
pub(crate) fn read_bounded(path: &Path, limit: u64) -> Result<Vec<u8>, Fault> {
    let file = File::open(path).map_err(Fault::Unreadable)?;
    let metadata = file.metadata().map_err(Fault::Unreadable)?;
    if metadata.len() > limit {
        return Err(Fault::TooLarge {
            what: Counted::Bytes,
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
            what: Counted::Bytes,
            found: bytes.len() as u64,
            limit,
        });
    }
    Ok(bytes)
}
