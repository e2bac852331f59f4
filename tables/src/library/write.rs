//! Writing of a table to its file.
//!
//! The HDF5 image is made in memory, so that the library never meets a full disk.

use std::path::Path;

use crate::error::Error;
use crate::file::output::Output;
use crate::library::BAKE_AGAIN;
use crate::library::{layout, scales, seal};
use crate::table::check;
use crate::table::table::Table;

/// Checks the place of the output, then writes a table as [`commit`] does.
///
/// # Errors
/// Returns the errors of [`Output::reserve`] and of [`commit`]. An old file is unchanged then.
pub fn write(table: &Table, path: &Path) -> Result<(), Error> {
    commit(table, Output::reserve(path)?)
}

/// Writes a table to the place that was reserved for it; equal tables give equal bytes.
///
/// # Errors
/// Returns an [`Error`] if the table breaks a rule, if the disk is full, if the file cannot be
/// replaced, or if the HDF5 library fails. An old file is unchanged then.
pub fn commit(table: &Table, output: Output) -> Result<(), Error> {
    let bytes = image(table, output.path())?;
    output.commit(&bytes)
}

/// Returns the bytes of a table's file; `name` is for messages.
fn image(table: &Table, name: &Path) -> Result<Vec<u8>, Error> {
    check::check(table).map_err(|broken| Error::file(name, broken, BAKE_AGAIN))?;
    let failed = |error| Error::hdf5(name, "file", &error);
    let file = layout::create().map_err(failed)?;
    layout::store(table, &file).map_err(|error| Error::hdf5(name, "table", &error))?;
    file.flush().map_err(failed)?;
    let mut bytes = scales::image(&file).map_err(failed)?;
    seal::append(&mut bytes);
    Ok(bytes)
}
