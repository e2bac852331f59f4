//! The optical model of a sheet, and its parameters from photographs: a, c and mu with standard
//! errors.
//!
//! Lengths are mm in the plane of the mid-air image, `a` and frequencies 1/mm, angles radians
//! unless a name ends in `_deg`. The method is that of Sugawara and Koizumi (SIGGRAPH Asia 2025
//! Posters).
//!
//! - [`model`]: the transfer function of shift, lobe, waves and camera.
//! - [`samples`]: the same blur by samples.
//! - [`compare`]: the model seen through the estimator of a photograph; the likelihood of pixels.
//! - [`estimate`]: a, c and mu with errors, bounds, verdict, suspects, and what is taken on trust.
//! - [`result`]: the file `result.json`.
//! - [`predict`]: MTF and luminance at other distances and angles.

#![forbid(unsafe_code)]

pub mod compare;
mod error;
pub mod estimate;
pub mod model;
pub mod predict;
pub mod result;
pub mod samples;

pub use error::{Conflict, Error};
