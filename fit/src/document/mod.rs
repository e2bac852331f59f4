//! TOML files, read key by key.
//!
//! A file enters. Checked values leave, or an error that names the file, the line, the key and what
//! to do. The room knows no photograph and no model. Manifests, parameters of a simulation, ranges
//! and views are all read through it. It may touch `names`.

mod bounds;
pub(crate) mod error;
mod line;
mod regular;
mod section;
mod text;

pub(crate) use bounds::Bounds;
pub(crate) use error::Error;
pub(crate) use line::FileLine;
pub(crate) use regular::open;
pub(crate) use section::{Document, NumberOrTable, Section};
pub(crate) use text::read;
