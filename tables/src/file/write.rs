//! A table to its file.
//!
//! The HDF5 image is made in memory, so that the library never meets a full disk.

use std::path::Path;

use crate::error::error::Error;
use crate::file::output::Output;
use crate::file::{layout, scales, seal};
use crate::table::check;
use crate::table::table::Table;

/// Writes a table: its place is checked, then [`commit`].
///
/// # Errors
/// [`Error::Output`], and those of [`commit`]; what was there before is unchanged then.
pub fn write(table: &Table, path: &Path) -> Result<(), Error> {
    commit(table, Output::reserve(path)?)
}

/// Writes a table to the place that was reserved for it; the same table always gives the same
/// bytes.
///
/// # Errors
/// [`Error::Invalid`] where the table breaks a rule, [`Error::Output`] where the disk is full or
/// the file cannot be replaced. What was there before is unchanged then.
pub fn commit(table: &Table, output: Output) -> Result<(), Error> {
    let bytes = image(table, output.path())?;
    Ok(output.commit(&bytes)?)
}

/// The bytes of a table's file; `name` is for messages.
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
