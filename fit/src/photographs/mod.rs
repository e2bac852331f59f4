//! Photographs, and the edges in them.
//!
//! A manifest and image files enter (EXR, PNG, TIFF, JPEG; camera raw with the feature `raw`).
//! Planes of linear light, edges, their profiles and measured MTFs leave, with warnings about what
//! disturbs them. The room knows no sheet and no model. It may touch `numerics`, `names` and
//! `document`.

pub(crate) mod captures;
mod chart;
mod correlation;
pub(crate) mod crossing;
mod defects;
pub(crate) mod edge;
mod illumination;
pub(crate) mod measure;
mod noise;
pub(crate) mod photo;
mod profile;
mod roi;
mod saturation;
pub(crate) mod sfr;
mod window;

pub use captures::{Campaign, Capture, Setup, Shot};
#[cfg(test)]
pub(crate) use edge::locate;
pub use measure::Measurement;
pub(crate) use noise::PixelNoise;
#[cfg(test)]
pub(crate) use photo::load_colour;
pub(crate) use profile::BIN_PX;
pub(crate) use profile::Profile;
pub(crate) use roi::Roi;
pub(crate) use sfr::Mtf;
#[cfg(test)]
pub(crate) use sfr::standard_error;
pub use sfr::{Estimator, crossing};
pub(crate) use window::{Raster, Window};
