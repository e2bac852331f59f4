//! TODO

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
