//! Ray shift in the aerial image: a table's direction seen along an edge normal.

use num_complex::Complex64;
use tables::Direction;

use crate::hermite::Samples;

/// Spacing and end of the tabulated OTF in kappa = c f (dimensionless).
///
/// A shift reaches at most 2 sqrt 2 edge lengths, so the fourth derivative is below (2 pi 2.83)^4 and the interpolation
/// error below 1e5 x step^4 / 384 = 1.5e-5; for the cells of model facts (reach 1.42) it is 1e-6.
const STEP: f64 = 1.0 / 64.0;
const END: f64 = 16.0;

/// The shift's OTF along one line: S(c f) for an edge normal in the aerial image.
#[derive(Debug, Clone)]
pub struct ShiftLine {
    samples: Samples<Complex64>,
}

impl ShiftLine {
    /// `normal` is the unit edge normal in the aerial image, (tangential, sagittal); `incidence_rad` the outside
    /// incidence, which foreshortens the tangential shift. `None` where nothing is retroreflected.
    pub fn new(direction: &Direction, incidence_rad: f64, normal: [f64; 2]) -> Option<ShiftLine> {
        if direction.eta <= 0.0 {
            return None;
        }
        let along = [normal[0] * incidence_rad.cos(), normal[1]];
        let kappa: Vec<f64> = (0..=(END / STEP) as usize)
            .map(|i| i as f64 * STEP)
            .collect();
        let (values, slopes) = direction.otf_and_slope_along(along, &kappa);
        Some(ShiftLine {
            samples: Samples::new(STEP, values, slopes),
        })
    }

    /// OTF and its derivative by `c` (mm) at a frequency in 1/mm. Beyond c f = 16 it is 0: lobes and cameras are dark
    /// there for cells up to 1 mm and frequencies up to 16 /mm.
    pub fn otf(&self, c: f64, frequency: f64) -> (Complex64, Complex64) {
        let kappa = c * frequency;
        if kappa > self.samples.end() {
            return (Complex64::ZERO, Complex64::ZERO);
        }
        let (value, slope) = self.samples.at(kappa);
        (value, slope * frequency)
    }
}
