//! Numerical methods: transforms, quadrature, triangular factors, least squares.
//!
//! Arrays of numbers and closures enter. Arrays of numbers leave. Each file states its accuracy.
//! Nothing here depends on light or photographs.

pub mod chance;
pub mod clip;
pub mod factor;
pub mod fourier;
mod quantile;
mod solve;
mod stream;
mod weights;

pub use fourier::{fast_length, sinc, smooth, smooth_even, smooth_odd};
pub use quantile::Quantile;
pub use solve::{CONVERGED, Evaluation, least_squares, least_squares_from};
pub use solve::{Solution, Stop};
pub use stream::Stream;
pub use weights::{GAUSS_16, lagrange};
