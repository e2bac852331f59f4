//! Mathematics without a field: transforms, interpolation, quadrature, least squares.
//!
//! Numbers enter and leave. The room may touch no other.

pub mod clip;
pub mod factor;
pub mod fourier;
pub mod quadrature;
pub mod sinc;
pub mod solve;
