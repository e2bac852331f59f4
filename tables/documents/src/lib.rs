//! TOML files, read into structs by serde.
//!
//! A file enters. Checked values leave, or an error with the file, line, key and remedy. Goals,
//! manifests, parameters of a simulation, ranges and views are all read here.

#![forbid(unsafe_code)]

mod bounds;
mod file;
mod text;

pub use bounds::{Bounded, Bounds, Table, table, tables};
pub use bounds::{choice, choices, finite, incidence, not_negative, positive};
pub use bounds::{share, turn};
pub use file::{open, read};
pub use text::{Document, Error, FileLine};
