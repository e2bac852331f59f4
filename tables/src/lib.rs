//! Ray-shift tables: axes, counts, fates, provenance, and the HDF5 file they live in.
//!
//! A [`Table`] holds, for each direction of incidence, how far a corner-cube sheet displaces the rays that it
//! returns. [`read()`] and [`write()`] move it from and to a file (`FORMAT.md` beside this crate), [`merge()`]
//! adds the rays of tables, [`Table::direction`] looks one direction up and [`Direction::otf_along`] is its
//! Fourier transform.
//!
//! ```
//! use std::path::Path;
//!
//! let table = tables::read(Path::new("tests/kept/version_1_rays.h5"))?;
//! let direction = table.direction(20.0, Some(30.0))?;
//! assert!((direction.eta - 0.5931).abs() < 5e-5);
//! // Its spectrum along u, at frequencies in cycles per edge length.
//! let otf = direction.otf_along([1.0, 0.0], &[0.0, 0.1, 0.2]);
//! assert!((otf[0].re - 1.0).abs() < 1e-13 && otf[2].norm() < otf[1].norm());
//! # Ok::<(), tables::Error>(())
//! ```
//!
//! A program that reads strangers' tables calls [`apart::serve`] first in its `main`.
//!
//! Frame and unit everywhere: shifts are (u, v) in the incidence frame of the entrance plane, u along the in-plane
//! travel direction, v = n x u, in edge lengths; angles in degrees.

#![deny(unsafe_code)]

pub mod apart;
mod between;
pub mod check;
#[cfg(feature = "cli")]
pub mod cli;
pub mod content;
pub mod counts;
pub mod deviation;
pub mod error;
mod heap;
pub mod invalid;
mod layout;
mod ledger;
mod limits;
pub mod lookup;
pub mod merge;
mod moved;
pub mod options;
pub mod output;
pub mod polygon;
pub mod provenance;
pub mod read;
mod received;
mod scales;
mod seal;
pub mod shards;
pub mod symmetry;
pub mod table;
pub mod transform;
mod waves;
pub mod write;

pub use counts::l1;
pub use deviation::Deviations;
pub use error::Error;
pub use invalid::Invalid;
pub use layout::VERSION;
pub use lookup::{Direction, NoDirection};
pub use merge::{Mismatch, merge};
pub use output::{Output, OutputError, Outputs};
pub use provenance::{GENERATOR, Provenance};
pub use read::{is_sealed, read};
pub use shards::Shards;
pub use symmetry::Symmetry;
pub use table::{Axes, Exact, Fate, Path, Table};
pub use write::{commit, write};
