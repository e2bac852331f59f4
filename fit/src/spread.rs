//! From an OTF along an edge normal to the edge profile on a photograph's own bins.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use num_complex::Complex64;
use realfft::{ComplexToReal, RealFftPlanner};

use crate::profile::{BIN_PX, Profile};
use crate::sfr::sinc;

/// The frequencies at which an OTF is wanted, and the transform from there to the bins.
#[derive(Clone)]
pub struct Grid {
    /// Length of the transform: bins of one period.
    size: usize,
    bin_mm: f64,
    inverse: Arc<dyn ComplexToReal<f64>>,
    /// Frequencies along the normal, 1/mm, from 0 to 2 per pixel.
    pub frequencies_per_mm: Vec<f64>,
}

impl Grid {
    /// A grid whose period is at least three profiles long, so that a blur of up to a whole profile does not come round.
    pub fn new(bins: usize, pitch_mm: f64) -> Grid {
        let size = (3 * bins).next_power_of_two().max(2048);
        let bin_mm = BIN_PX * pitch_mm;
        let period = size as f64 * bin_mm;
        Grid {
            size,
            bin_mm,
            inverse: RealFftPlanner::new().plan_fft_inverse(size),
            frequencies_per_mm: (0..=size / 2).map(|q| q as f64 / period).collect(),
        }
    }

    /// Mean of the edge profile over the pixels of every bin.
    ///
    /// `otf` at the grid's frequencies; its first value scales the step (1 for a profile, 0 for a derivative). `kink` is
    /// -d OTF/d|f| at 0 (mm): a kinked OTF has 1/s^2 tails, whose periodic images are taken out to second order. The
    /// profile is the inverse transform at evenly filled bins, exact but for the images of a lobe wider than a profile;
    /// a bin's excess moments (a few hundredths of a pixel) are then put in with the profile's own differences, whose
    /// slope is good to (pi/4)^4/30 = 1.3 % at half the sampling frequency and to 1e-5 at a tenth of it.
    pub fn profile(&self, otf: &[Complex64], kink: f64, profile: &Profile) -> Vec<f64> {
        let period = self.size as f64 * self.bin_mm;
        let step = otf[0].re;
        let mut half: Vec<Complex64> = otf
            .iter()
            .zip(&self.frequencies_per_mm)
            .map(|(o, &f)| o * sinc(PI * f * self.bin_mm) / Complex64::new(0.0, TAU * f * period))
            .collect();
        half[0] = Complex64::from(step / period);
        // The last coefficient is real; what is dropped lies at 2 per pixel, beyond every camera's reach.
        half[self.size / 2].im = 0.0;
        let mut periodic = vec![0.0; self.size];
        self.inverse
            .process(&mut half, &mut periodic)
            .expect("lengths and reality are set above");
        // C/s^2 is the tail of the line spread; its images sum to C pi^2/(3 P^2) + C pi^4 s^2/(15 P^4) + ...
        let tail = kink / (2.0 * PI * PI);
        let (first, cubic) = (
            tail * PI.powi(2) / (3.0 * period.powi(2)),
            tail * PI.powi(4) / (45.0 * period.powi(4)),
        );
        let at = |offset: i64| {
            let s = offset as f64 * self.bin_mm;
            let index = offset.rem_euclid(self.size as i64) as usize;
            step * (0.5 + s / period) + periodic[index] - first * s - cubic * s.powi(3)
        };
        let reach = profile.reach as i64;
        let even: Vec<f64> = (-reach - 2..=reach + 2).map(at).collect();
        let mut bins: Vec<f64> = (0..profile.len())
            .map(|j| {
                let [m1, m2, m3] = profile.excess[j];
                let (m1, m2, m3) = (m1 / BIN_PX, m2 / BIN_PX.powi(2), m3 / BIN_PX.powi(3));
                let [b2, b1, here, a1, a2] =
                    [even[j], even[j + 1], even[j + 2], even[j + 3], even[j + 4]];
                // Fourth-order differences; per bin.
                let slope = (8.0 * (a1 - b1) - (a2 - b2)) / 12.0;
                let curvature = (16.0 * (a1 + b1) - (a2 + b2) - 30.0 * here) / 12.0;
                let third = 0.5 * (a2 - b2) - (a1 - b1);
                here + slope * m1 + 0.5 * curvature * m2 + third * m3 / 6.0
            })
            .collect();
        profile.bridge(&mut bins);
        bins
    }
}
