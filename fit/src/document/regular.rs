//! Opening of files that come from strangers, or whose names do.

use std::fs::{File, metadata};
use std::io;
use std::path::Path;

/// Opens a regular file for reading.
///
/// # Errors
/// Returns an error for a folder, a pipe and a device, which could be waited for without end, and
/// the errors of opening a file.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    let regular = |is: bool| {
        is.then_some(()).ok_or_else(|| {
            io::Error::new(
                io::ErrorKind::InvalidInput,
                "it is a folder, a pipe or a device, not a regular file",
            )
        })
    };
    // Opening a pipe would wait already. The name may lead elsewhere a moment later.
    regular(metadata(path)?.is_file())?;
    let file = File::open(path)?;
    regular(file.metadata()?.is_file())?;
    Ok(file)
}
