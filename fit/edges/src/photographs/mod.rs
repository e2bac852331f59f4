//! Photographs, and the edges in them.
//!
//! A manifest and image files enter (EXR, PNG, TIFF, JPEG; camera raw with the feature `raw`).
//! Planes of linear light, edges, their profiles and measured MTFs leave, with warnings about what
//! disturbs them. This module depends on no sheet and no model.

mod band;
mod chart;
pub mod crossing;
pub mod edge;
mod illumination;
pub mod manifest;
pub mod measure;
pub mod photo;
mod pixels;
mod profile;
pub mod sfr;
mod window;

pub use edge::locate;
pub use manifest::captures::{Campaign, Capture, Shot};
pub use manifest::roi::Roi;
pub use manifest::setup::Setup;
pub use measure::Measurement;
#[cfg(test)]
pub(crate) use photo::load_colour;
pub use pixels::noise::PixelNoise;
pub use profile::Profile;
pub use profile::{BIN_PX, bin_at};
pub use sfr::Mtf;
#[cfg(test)]
pub(crate) use sfr::standard_error;
pub use sfr::{Estimator, crossing};
pub use window::{Raster, Window};
