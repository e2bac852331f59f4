//! stub
use crate::lookup::Direction;
use num_complex::Complex64;
impl Direction {
    /// stub
    pub fn otf_along(&self, _w: [f64; 2], kappa: &[f64]) -> Vec<Complex64> {
        vec![Complex64::new(0.0, 0.0); kappa.len()]
    }
}
