//! Mathematics for all rooms: transforms, quadrature, triangular factors, least squares.
//!
//! Arrays of numbers and closures enter. Arrays of numbers leave. Each file states its accuracy.
//! Nothing here knows of light or photographs. This is the lowest room: it may touch no other.

pub(crate) mod chance;
pub(crate) mod clip;
pub(crate) mod factor;
pub(crate) mod fourier;
pub(crate) mod lagrange;
mod quadrature;
pub(crate) mod sinc;
mod solve;

pub(crate) use fourier::{fast_length, smooth, smooth_even, smooth_odd};
pub(crate) use quadrature::GAUSS_16;
pub(crate) use solve::{CONVERGED, Evaluation, least_squares, least_squares_from};
pub(crate) use solve::{Solution, Stop};
