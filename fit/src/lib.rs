//! Estimates the diffraction spread `a`, corner size `c` and reflectance `mu` of a retroreflective sheet from
//! photographs of mid-air images.

#![forbid(unsafe_code)]

pub mod cli;
pub mod compare;
pub mod document;
pub mod estimate;
#[cfg(feature = "images")]
pub mod images;
pub mod model;
pub mod names;
pub mod numerics;
pub mod photographs;
pub mod predict;
#[cfg(feature = "report")]
pub mod report;
pub mod result;
pub mod samples;
pub mod simulate;
pub mod study;

#[cfg(test)]
mod tests;
