//! Ray-shift tables: axes, counts, fates, provenance, and the HDF5 file that holds them.
//!
//! A [`Table`] holds, for each direction of incidence, how far a corner-cube sheet displaces the
//! rays that it returns. [`read()`] and [`write()`] move it from and to a file (`FORMAT.md` beside
//! this crate). [`merge()`] adds the rays of tables. [`Table::direction`] looks up one direction,
//! and [`Direction::otf_along`] is its Fourier transform.
//!
//! ```
//! use std::path::Path;
//!
//! let table = tables::read(Path::new("tests/kept/version_1_rays.h5"))?;
//! let direction = table.direction(20.0, Some(30.0))?;
//! assert!((direction.retroreflected - 0.5931).abs() < 5e-5);
//! // Its spectrum along u, at frequencies in cycles per edge length.
//! let otf = direction.otf_along([1.0, 0.0], &[0.0, 0.1, 0.2]);
//! assert!((otf[0].re - 1.0).abs() < 1e-13 && otf[2].norm() < otf[1].norm());
//! # Ok::<(), tables::Error>(())
//! ```
//!
//! A program that reads strangers' tables calls [`apart::start`] first in its `main`.
//!
//! Frame and unit everywhere: shifts are (u, v) in the incidence frame of the entrance plane, in
//! edge lengths. u points along the in-plane travel direction, and v = n x u. Angles are in
//! degrees.

#![deny(unsafe_code)]
#![warn(unreachable_pub)]

// Each module imports only those before it.
#[cfg(feature = "cli")]
pub mod cli;
mod error;
mod file;
#[cfg(feature = "hdf5")]
mod library;
mod lookup;
#[cfg(feature = "hdf5")]
mod merge;
pub mod options;
mod otf;
mod table;

// The public interface. A table and its parts:
pub use table::axes::Axes;
pub use table::check::{MOST_DIRECTIONS, check};
pub use table::counts::l1;
pub use table::deviation::{self, Deviations};
pub use table::exact::{Cube, Exact, Jones, Path};
pub use table::fate::Fate;
pub use table::polygon;
pub use table::provenance::{
    GENERATOR, GENERATOR_BEHIND_FRONT, GENERATOR_OF_LOSSY_FRONT, GENERATOR_OF_ROUGH, Provenance,
};
pub use table::shards::{MOST_SHARDS, Shards};
pub use table::symmetry::Symmetry;
pub use table::table::Table;
// What can be wrong:
pub use error::Error;
pub use table::check::Invalid;
// A direction and its spectrum:
pub use lookup::direction::Direction;
pub use lookup::family::Family;
pub use lookup::passage::{Matrix, Passage};
pub use otf::hermite::Samples;
pub use otf::shift::ShiftLine;
pub use otf::wave::{NoWaves, WaveLine};
// Tables put together, and files:
pub use file::apart;
pub use file::output::{Output, Outputs};
pub use file::partial::scratch_folder;
pub use file::read::{read, read_in_memory};
pub use file::reader;
#[cfg(feature = "hdf5")]
pub use library::layout::VERSION;
#[cfg(feature = "hdf5")]
pub use library::read::is_sealed;
#[cfg(feature = "hdf5")]
pub use library::write::{commit, write};
#[cfg(feature = "hdf5")]
pub use merge::merge::merge;
