//! Light of one direction that leaves in one direction, along one line.

use num_complex::Complex64;

use crate::otf::hermite::Samples;

/// Light that leaves in one direction.
#[derive(Debug, Clone)]
pub(crate) struct LineSpot {
    /// Factor of the samples.
    pub share: f64,
    /// Tangent of its deviation along the edge normal.
    pub deviation: f64,
    /// Shift along the edge normal, edge lengths, that the samples leave out.
    pub middle: f64,
    /// OTF by c f.
    pub samples: Samples<Complex64>,
}
