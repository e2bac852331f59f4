//! Light of one direction of a table that leaves in one direction, along one line.

use num_complex::Complex64;

use crate::otf::hermite::Samples;

/// Light that leaves in one direction.
#[derive(Debug, Clone)]
pub(crate) struct LineSpot {
    /// Factor of the samples.
    pub share: f64,
    /// Tangent of the deviation along the edge normal.
    pub deviation: f64,
    /// Shift along the edge normal that the samples leave out, edge lengths.
    pub middle: f64,
    /// OTF as a function of c f.
    pub samples: Samples<Complex64>,
}
