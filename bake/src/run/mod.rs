//! The bake: a prepared cell and a plan become a table, on all threads and ranks.
//!
//! [`bake::trace`] does the whole bake. [`checks::retrace`] checks the numbers of a table
//! against its mesh, [`checks::claims`] what it says about its bake. [`checks::comparison`] compares
//! two tables. A [`bake::Progress`] is told the rays done and can stop the bake. Nothing is
//! printed. Only the file `saves` knows the disk, and only `world` knows MPI.

mod bake;
mod between;
mod checks;
mod cuts;
mod directions;
mod exits;
mod paths;
mod provenance;
mod ranks;
pub(crate) mod remarks;
mod rounds;
pub(crate) mod saves;
mod work;
#[cfg(feature = "mpi")]
mod world;

pub(crate) use bake::{Bake, Baked};
pub use bake::{Progress, trace};
pub(crate) use between::Between;
pub use checks::claims::{Claims, Contradiction, Unchecked, claims};
pub use checks::comparison::{Comparison, Difference};
pub use checks::retrace::{error_between, rebake, retrace};
pub use exits::ExitGap;
pub use paths::{Forged, consistent};
#[cfg(test)]
pub(crate) use ranks::Alone;
pub(crate) use ranks::{Launched, Ranks, agreed, start};
pub(crate) use saves::{SavedFile, Saves};
