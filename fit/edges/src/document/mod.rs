//! TOML files, read into structs by serde.
//!
//! A file enters. Checked values leave, or an error that names the file, the line, the key and what
//! to do. The room knows no photograph and no model. Manifests, parameters of a simulation, ranges
//! and views are all read through it. It may touch `names`.

mod bounds;
mod file;
mod text;

pub use bounds::{Bounded, Bounds, Table, table};
pub use bounds::{choice, choices, finite, incidence, not_negative, positive};
pub use bounds::{share, spectrum, turn};
pub use file::{open, read};
pub use text::{Document, Error, FileLine};
