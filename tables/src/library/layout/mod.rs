//! Round trip between a table and an HDF5 file.
//!
//! `names` holds every HDF5 name, `store` writes, and `load` reads without trust in the file.

mod deviations;
mod flat;
mod load;
mod names;
mod place;
mod polygons;
mod store;

pub(crate) use load::load;
pub use names::VERSION;
pub(crate) use store::{create, store};
