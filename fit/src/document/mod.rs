//! TOML files, read key by key.
//!
//! A file enters; checked values leave, or an error that names the file, the line, the key and what to do. The room
//! knows no photograph and no model: manifests, parameters of a simulation, ranges and views are all read through it.
//! It may touch `names`.

pub mod bounds;
pub mod error;
pub mod line;
pub mod section;
pub mod text;
