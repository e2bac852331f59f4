//! HDF5 files of tables, and outputs that appear whole or not at all.
//!
//! A path enters and a checked table leaves, or a table enters and bytes leave. This module alone
//! names HDF5. Strangers' files are opened by another program ([`apart`], [`reader`]) under limits
//! of memory and time.

pub mod apart;
pub(crate) mod content;
pub(crate) mod heap;
pub(crate) mod layout;
pub(crate) mod library;
pub(crate) mod limits;
pub(crate) mod output;
pub(crate) mod partial;
pub(crate) mod read;
pub mod reader;
pub(crate) mod received;
pub(crate) mod scales;
pub(crate) mod seal;
