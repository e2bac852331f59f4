//! Mathematics without a field: transforms, interpolation, quadrature, least squares.
//!
//! Arrays of numbers and closures enter; arrays of numbers leave, with the accuracy that each file states. Nothing here
//! knows of light or photographs. This is the ground room: it may touch no other.

pub mod clip;
pub mod factor;
pub mod fourier;
pub mod quadrature;
pub mod sinc;
pub mod solve;
