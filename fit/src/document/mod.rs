//! TOML files, read into structs by serde.
//!
//! A file enters. Checked values leave, or an error that names the file, the line, the key and what
//! to do. The room knows no photograph and no model. Manifests, parameters of a simulation, ranges
//! and views are all read through it. It may touch `names`.

mod bounds;
mod file;
mod text;

pub(crate) use bounds::{Bounded, Bounds, Table, readers, table};
pub(crate) use bounds::{choice, choices, finite, incidence, not_negative, positive};
pub(crate) use bounds::{share, spectrum, turn};
pub(crate) use file::{open, read};
pub(crate) use text::{Document, Error, FileLine};
