//! Outputs that appear whole or not at all, and tables that another program reads.
//!
//! Strangers' files are opened by another program ([`apart`], [`reader`]) under limits of memory and
//! time. What opens them with the HDF5 library is `crate::library`.

pub mod apart;
pub(crate) mod content;
pub(crate) mod limits;
pub(crate) mod output;
pub(crate) mod partial;
pub(crate) mod read;
pub mod reader;
pub(crate) mod received;
