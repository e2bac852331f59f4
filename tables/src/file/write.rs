//! Writing of a table to its file.
//!
//! The HDF5 image is made in memory, so that the library never meets a full disk.

use std::path::Path;

use crate::error::error::Error;
use crate::file::output::Output;
use crate::file::{layout, scales, seal};
use crate::table::check;
use crate::table::table::Table;

/// Checks the place of the output, then writes a table as [`commit`] does.
///
/// # Errors
/// Returns [`Error::Output`] if the file cannot be written, and the errors of [`commit`]. An old
/// file is unchanged then.
pub fn write(table: &Table, path: &Path) -> Result<(), Error> {
    commit(table, Output::reserve(path)?)
}

/// Writes a table to the place that was reserved for it; equal tables give equal bytes.
///
/// # Errors
/// Returns [`Error::Invalid`] if the table breaks a rule, [`Error::Output`] if the disk is full or
/// the file cannot be replaced, and [`Error::Hdf5`] if the HDF5 library fails. An old file is
/// unchanged then.
pub fn commit(table: &Table, output: Output) -> Result<(), Error> {
    let bytes = image(table, output.path())?;
    Ok(output.commit(&bytes)?)
}

/// Returns the bytes of a table's file; `name` is for messages.
pub(crate) fn image(table: &Table, name: &Path) -> Result<Vec<u8>, Error> {
    check::check(table).map_err(|source| Error::Invalid {
        file: name.to_owned(),
        source,
    })?;
    let place = |place: &str| {
        let place = place.to_owned();
        move |source| Error::Hdf5 {
            file: name.to_owned(),
            place,
            source,
        }
    };
    let file = layout::create().map_err(place("file"))?;
    layout::store(table, &file).map_err(place("table"))?;
    file.flush().map_err(place("file"))?;
    let mut bytes = scales::image(&file).map_err(place("file"))?;
    seal::append(&mut bytes);
    Ok(bytes)
}
