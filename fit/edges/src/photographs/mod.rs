//! Photographs, and the edges in them.
//!
//! A manifest and image files enter (EXR, PNG, TIFF, JPEG; camera raw with the feature `raw`).
//! Planes of linear light, edges, their profiles and measured MTFs leave, with warnings about what
//! disturbs them. This module depends on no sheet and no model.

mod band;
pub mod captures;
mod chart;
mod correlation;
pub mod crossing;
mod defects;
pub mod edge;
mod illumination;
pub mod lamp;
pub mod measure;
mod noise;
pub mod photo;
mod processing;
mod profile;
mod roi;
mod saturation;
mod setup;
pub mod sfr;
mod window;

pub use captures::{Campaign, Capture, Shot};
pub use edge::locate;
pub use measure::Measurement;
pub use noise::PixelNoise;
#[cfg(test)]
pub(crate) use photo::load_colour;
pub use profile::BIN_PX;
pub use profile::Profile;
pub use roi::Roi;
pub use setup::Setup;
pub use sfr::Mtf;
#[cfg(test)]
pub(crate) use sfr::standard_error;
pub use sfr::{Estimator, crossing};
pub use window::{Raster, Window};
