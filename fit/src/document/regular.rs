//! Opening of files that come from strangers, or whose names do.

use std::fs::{File, Metadata, metadata};
use std::io;
use std::path::Path;

/// Opens a regular file for reading.
///
/// # Errors
/// Returns an error for a folder, a pipe and a device, which could be waited for without end, and
/// the errors of opening a file.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    // Opening a pipe would wait already. The name may lead elsewhere a moment later.
    regular(&metadata(path)?)?;
    let file = File::open(path)?;
    regular(&file.metadata()?)?;
    Ok(file)
}

fn regular(found: &Metadata) -> io::Result<()> {
    let why = match (found.is_file(), found.is_dir()) {
        (true, _) => return Ok(()),
        (false, true) => "it is a folder; name a file in it",
        (false, false) => "it is a pipe or a device, not a regular file",
    };
    Err(io::Error::new(io::ErrorKind::InvalidInput, why))
}
