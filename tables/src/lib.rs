//! Ray-shift tables: axes, counts, fates, provenance, and the HDF5 file they live in.

pub mod table;

pub use table::{Axes, Exact, Fate, Path, Provenance, Table};
