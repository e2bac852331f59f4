//! Simulated campaigns: photographs with a planted answer, the truth.
//!
//! Parameters enter. Photographs with noise, their manifest and the truth leave. The simulator uses
//! other methods than the model, so that an estimate from its photographs tests the model: shifts
//! in closed form, convolutions in space, no OTF. So it takes only `names`, `document` and plain
//! `numerics` from the crate `edges`, and nothing from the estimator. Sheets that a table describes
//! come from the crate `tables`.

mod camera;
pub(crate) mod cell;
pub mod error;
pub(crate) mod jpeg;
mod lobe_edge;
mod masses;
mod noise;
pub(crate) mod params;
pub(crate) mod photograph;
mod profile;
mod sheet;
mod wave_edge;
pub mod write;

pub use camera::PlantedCamera;
pub(crate) use error::Error;
pub(crate) use noise::PixelNoise;
pub use params::Params;
pub(crate) use params::lobe;
pub(crate) use params::{ByIncidence, PlantedEdge, PlantedSheet, PlantedShot};
pub(crate) use write::run;
