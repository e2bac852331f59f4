//! Photographs of a slanted edge, measured: files and manifests in, edges and MTFs out.
//!
//! Light is linear and in any unit, lengths are pixels or mm in the plane of the mid-air image, and
//! frequencies are cycles per pixel or 1/mm. The crate knows no ray, no table and no model of a
//! sheet.
//!
//! - [`numerics`]: Fourier transforms, least squares, quadrature, with the accuracy of each.
//! - [`names`]: kernels, lobes, parameters and spectra. The simulator of `lab` shares these names
//!   with the model, and nothing else.
//! - [`document`]: TOML by serde, with file, line, key and remedy in each error.
//! - [`photographs`]: manifest and files to linear light, edge, profile and MTF.

#![forbid(unsafe_code)]

pub mod document;
pub mod names;
pub mod numerics;
pub mod photographs;
#[cfg(test)]
mod tests;

pub use documents::readers;
