//! Decoders: the bytes of a file become samples as they are stored.

pub(super) mod jpeg;
pub(super) mod openexr;
pub(super) mod pages;
mod parts;
pub(super) mod png;
#[cfg_attr(not(feature = "raw"), path = "no_raw.rs")]
pub(super) mod raw;
mod scans;
pub(super) mod tiff;
