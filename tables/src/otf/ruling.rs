//! Spacing and origin of the tabulated OTF along one line.

use num_complex::Complex64;
use std::f64::consts::TAU;

use crate::lookup::direction::Direction;
use crate::otf::hermite::Samples;
use crate::table::exact::Path;

/// Spacing in kappa = c f (dimensionless) where shifts are near.
///
/// With shifts up to [`NEAR`] the fourth derivative is below (2 pi 2.83)^4, and the interpolation
/// error is below 1e5 x step^4 / 384 = 1.6e-5. For cells whose shifts reach 1.42 edge lengths it is
/// 1e-6.
pub(crate) const STEP: f64 = 1.0 / 64.0;

/// Greatest tabulated kappa.
const END: f64 = 16.0;

/// Greatest shift in cubes, edge lengths: 2 sqrt 2.
const NEAR: f64 = 2.83;

/// Greatest divisor of the spacing.
///
/// Shifts that lie 360 edge lengths apart still have the error of [`STEP`].
const FINEST: f64 = 64.0;

/// Origin and spacing for tabulating the OTF of the shifts along a line.
///
/// Near shifts are tabulated as they are. Farther shifts are tabulated about their middle, with a
/// spacing that their distance from it needs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ruling {
    /// Shift that is left out of the samples, edge lengths along the line.
    pub middle: f64,
    /// Whole number by which the spacing of [`STEP`] is divided.
    pub finer: f64,
}

impl Ruling {
    /// Finds the ruling for the shifts of polygons; `along` is the line, foreshortened.
    pub(crate) fn of_paths(paths: &[Path], along: [f64; 2]) -> Ruling {
        let corners = paths
            .iter()
            .flat_map(|path| path.polygon.iter().map(|&entry| path.shift(entry)));
        Ruling::new(corners.map(|[u, v]| along[0] * u + along[1] * v))
    }

    /// Finds the ruling for the bins that hold light.
    pub(crate) fn of_bins(direction: &Direction, along: [f64; 2]) -> Ruling {
        let width = 2.0 * direction.range / direction.probability.ncols() as f64;
        let centre = |i: usize| (i as f64 + 0.5) * width - direction.range;
        let half = 0.5 * width * (along[0].abs() + along[1].abs());
        let held = direction.probability.indexed_iter();
        let held = held.filter(|(_, p)| **p > 0.0).flat_map(|((v, u), _)| {
            let x = along[0] * centre(u) + along[1] * centre(v);
            [x - half, x + half]
        });
        Ruling::new(held)
    }

    /// Finds the ruling for some shifts along the line.
    fn new(shifts: impl Iterator<Item = f64>) -> Ruling {
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = shifts.fold(ends, |(low, high), x| (low.min(x), high.max(x)));
        // Without shifts, `high` and `-low` are minus infinity, which counts as near.
        if high.max(-low) <= NEAR {
            return Ruling {
                middle: 0.0,
                finer: 1.0,
            };
        }
        let reach = 0.5 * (high - low);
        Ruling {
            middle: 0.5 * (low + high),
            finer: (reach / NEAR).ceil().clamp(1.0, FINEST),
        }
    }

    /// Returns the spacing of the samples in kappa.
    pub(crate) fn step(&self) -> f64 {
        STEP / self.finer
    }

    /// Returns the kappa of the samples.
    pub(crate) fn kappa(&self) -> impl Iterator<Item = f64> + use<> {
        let (step, count) = (self.step(), (END / STEP * self.finer) as usize);
        (0..=count).map(move |i| i as f64 * step)
    }

    /// Returns the OTF of the direction, without the phase of the middle.
    pub(crate) fn samples(&self, direction: &Direction, along: [f64; 2]) -> Samples<Complex64> {
        let kappa: Vec<f64> = self.kappa().collect();
        let (mut values, mut slopes) = direction.otf_and_slope_along(along, &kappa);
        if self.middle != 0.0 {
            let turning = Complex64::new(0.0, TAU * self.middle);
            for ((value, slope), kappa) in values.iter_mut().zip(&mut slopes).zip(&kappa) {
                let back = Complex64::cis(TAU * self.middle * kappa);
                *slope = (*slope + *value * turning) * back;
                *value *= back;
            }
        }
        Samples::new(self.step(), values, slopes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    /// Two lit bins, 4 edge lengths wide, lie at (6, -6) and (6, 6). Along (0.8, 0.6) their middles
    /// are at 1.2 and 8.4, and each reaches 2 (0.8 + 0.6) = 2.8 to both sides: -1.6 to 11.2.
    #[test]
    fn rulings_of_bins_reach_to_the_corners_of_bins() {
        let mut probability = Array2::zeros((4, 4));
        probability[(0, 3)] = 0.25;
        probability[(3, 3)] = 0.25;
        let direction = Direction {
            incidence_deg: 0.0,
            azimuth_deg: 0.0,
            retroreflected: 0.5,
            probability,
            range: 8.0,
            standard_error: 0.0,
            interpolated: false,
            paths: None,
            exits: None,
        };
        let ruling = Ruling::of_bins(&direction, [0.8, 0.6]);
        assert!((ruling.middle - 4.8).abs() < 1e-14, "{}", ruling.middle);
        // Half of 12.8 is 2.26 times 2.83.
        assert_eq!(ruling.finer, 3.0);
        assert_eq!(ruling.step(), 1.0 / 192.0);
    }
}
