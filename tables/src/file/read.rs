//! Reading of a table from its file, checked to the last bit before it is used.

use std::path::Path;

use crate::error::Error;
use crate::file::here::{content, opened};
use crate::file::seal::Seal;
use crate::file::{apart, seal};
use crate::table::table::Table;

/// Reads a table and checks everything in it.
///
/// It checks signature, seal, format, version, types, shapes, sizes before allocation, finite
/// values, the rules of `crate::table::check`, counts against what is derived from them, and the
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

/// Returns whether the file still ends with the seal that [`crate::write()`] puts there.
///
/// A program that opens the table for writing removes the seal. Then only the content hash vouches
/// for the content.
///
/// # Errors
/// Returns an [`Error`] if the file cannot be read.
pub fn is_sealed(path: &Path) -> Result<bool, Error> {
    let (file, bytes) = opened(path)?;
    Ok(seal::check(&content(file, bytes, path)?) == Seal::Intact)
}
