//! Campaigns of photographs with a planted answer.
//!
//! Parameters enter; photographs with noise, their manifest and the truth leave. The room is another road than the
//! model's, so that an estimate from its photographs tests the model: shifts in closed form, convolutions in space,
//! no transfer function. So it may touch the names of kernels and lobes, TOML documents and plain numerics, but
//! neither the model nor the photographs' room. Its sheets by a table come from the crate `tables`.

pub mod cell;
pub mod error;
pub mod lobe_edge;
pub mod noise;
pub mod params;
pub mod photograph;
pub mod profile;
pub mod sheet;
pub mod truth;
pub mod wave_edge;
pub mod write;
