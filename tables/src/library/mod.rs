//! The HDF5 file of a table, written and read by the HDF5 library.
//!
//! A table enters and bytes leave, or bytes enter and a checked table leaves. This module alone
//! names HDF5. `fit` is built without it, for it has tables read by another program
//! ([`crate::apart`]).

pub(crate) mod answer;
pub(crate) mod confine;
pub(crate) mod heap;
pub(crate) mod layout;
pub(crate) mod memory;
pub(crate) mod read;
pub(crate) mod scales;
pub(crate) mod seal;
pub(crate) mod write;

use std::path::Path;

use crate::error::Error;

/// Remedy for a table whose numbers or attributes contradict one another.
pub(crate) const BAKE_AGAIN: &str = "bake the table again";

/// Remedy for a name that belongs to no table.
pub(crate) const NAME_A_TABLE: &str = "name a table written by `bake trace`";

/// Remedy for a file whose bytes have changed.
pub(crate) const COPY_AGAIN: &str = "copy it again or bake it again";

impl Error {
    /// Makes the error of a file of which the HDF5 library cannot read or write `place`.
    pub(crate) fn hdf5(file: &Path, place: &str, error: &hdf5::Error) -> Error {
        Error::file(
            file,
            format!("{place} cannot be read or written ({error})"),
            "the file is cut short or damaged, copy it again or bake it again",
        )
    }
}
