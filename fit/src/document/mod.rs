//! TOML files, read key by key.
//!
//! The room takes a file and gives checked values, or an error that names the file, the line, the
//! key and what to do. It knows no photograph and no model. Manifests, parameters of a simulation,
//! ranges and views are all read through it. It may use only the room `names`.

mod bounds;
pub(crate) mod error;
mod line;
mod section;
mod text;

pub(crate) use bounds::Bounds;
pub(crate) use error::Error;
pub(crate) use line::FileLine;
pub(crate) use section::{Document, NumberOrTable, Section};
pub(crate) use text::read;
