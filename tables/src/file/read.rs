//! Reading of a table, by another program where there is one.

use std::fs::File;
use std::io::{self, Seek, Write};
use std::path::Path;

use crate::error::{BAKE_LESS, Error};
use crate::file::apart;
use crate::table::table::Table;

/// Reads a table and checks everything in it.
///
/// It checks signature, seal, format, version, types, shapes, sizes before allocation, finite
/// values, the rules of [`crate::check()`], counts against what is derived from them, and the
/// content hash. Links that leave the file, unknown filters and inflated chunks are refused. If
/// there are counts, all other numbers are computed from them, so that two readers hold the same
/// bits.
///
/// In a program that calls [`crate::file::apart::start`] first, the HDF5 library opens the file in
/// another program, and a crash of the library becomes an error here.
///
/// # Errors
/// Returns an [`Error`] if a check fails. It names the file, the dataset or attribute, and the
/// remedy.
///
/// ```
/// let error = tables::read(std::path::Path::new("Cargo.toml")).unwrap_err();
/// assert!(error.to_string().contains("is not an HDF5 file"));
/// ```
pub fn read(path: &Path) -> Result<Table, Error> {
    Ok(apart::read(path)?.table)
}

/// Reads a table from the bytes of a file, as [`read()`] does; `name` is for messages.
///
/// # Errors
/// Returns an [`Error`] if a check fails, or if there is no place for a temporary file.
pub fn read_in_memory(bytes: &[u8], name: &Path) -> Result<Table, Error> {
    let file = || {
        let mut file = tempfile::tempfile()?;
        file.write_all(bytes)?;
        file.rewind()?;
        io::Result::Ok(file)
    };
    let file = file().map_err(|error| {
        let fault = format!("cannot be handed to the program that reads it ({error})");
        let remedy = "let TMPDIR name a folder that takes files";
        Error::file(name, fault, remedy)
    })?;
    Ok(apart::read_file(file, bytes.len() as u64, name)?.table)
}

/// Longest file that is read, bytes: the largest table within the memory limit, incompressible.
pub(crate) const MOST_BYTES: u64 = (1 << 31) + (1 << 24);

/// Opens a file and returns it with its length in bytes.
///
/// Nothing else is opened: a pipe would wait for its writer, a device may do so.
///
/// # Errors
/// Returns an [`Error`] if the file cannot be opened, is no regular file, or is longer than any
/// table.
pub(crate) fn opened(path: &Path) -> Result<(File, u64), Error> {
    let failed = |error| unreadable(path, &error);
    let not_a_file = || {
        let remedy = "name a table such as table.h5";
        Error::file(path, "is not a regular file", remedy)
    };
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        return Err(not_a_file());
    }
    let file = File::open(path).map_err(failed)?;
    // The name may lead elsewhere by now.
    let metadata = file.metadata().map_err(failed)?;
    if !metadata.is_file() {
        return Err(not_a_file());
    }
    let bytes = metadata.len();
    if bytes > MOST_BYTES {
        let fault = format!("is {bytes} bytes, above the limit of {MOST_BYTES}");
        return Err(Error::file(path, fault, BAKE_LESS));
    }
    Ok((file, bytes))
}

/// Makes the error of a file that the system does not let this program read.
pub(crate) fn unreadable(path: &Path, error: &io::Error) -> Error {
    let fault = format!("cannot be read ({error})");
    Error::file(path, fault, "check the name and the permissions")
}
