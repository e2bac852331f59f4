//! Simulated campaigns: photographs with a planted answer, the truth.
//!
//! The room takes parameters and gives photographs with noise, their manifest and the truth. It
//! computes in another way than the model, so an estimate from its photographs tests the model:
//! shifts in closed form, convolutions in space, no OTF. So it may use the names of kernels and
//! lobes, TOML documents and plain numerics, but neither the model nor the room `photographs`.
//! Sheets that a table describes come from the crate `tables`.

pub(crate) mod cell;
pub(crate) mod error;
mod lobe_edge;
mod noise;
mod params;
pub(crate) mod photograph;
mod profile;
mod sheet;
mod truth;
mod wave_edge;
pub(crate) mod write;

pub(crate) use error::Error;
pub(crate) use noise::PixelNoise;
pub use params::Params;
pub(crate) use params::{ByIncidence, PlantedCamera, PlantedEdge, PlantedSheet, PlantedShot};
pub(crate) use params::{CAMERA, camera};
pub(crate) use truth::Truth;
#[cfg(test)]
pub(crate) use write::run;
