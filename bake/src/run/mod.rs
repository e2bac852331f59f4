//! TODO

pub mod directions;
pub mod provenance;
pub mod ranks;
pub mod retrace;
pub mod run;
pub mod saves;
pub mod work;
#[cfg(feature = "mpi")]
pub mod world;
