//! TODO

pub mod clip;
pub mod factor;
pub mod fourier;
pub mod solve;
