//! The camera of a scene, and how well its lens is known: measured on references, or assumed.

use nalgebra::{DMatrix, DVector};

use crate::model::{Camera, Lens};

/// Step of the lens parameters for numerical derivatives.
pub(crate) const STEP: f64 = 1e-4;

/// Standard deviation of the Gaussian that is assumed for a lens that nobody measured, pixels.
///
/// It is the median of the assumption. Lenses in focus blur by 0.3 to 0.8 pixels.
const ASSUMED_PX: f64 = 0.5;

/// Factor by which an unknown lens may blur more or less, as one standard deviation. So it blurs by
/// 0.25 to 1 pixel in two of three cameras, and by 0.13 to 2 pixels in 19 of 20.
const ASSUMED_FACTOR: f64 = 2.0;

/// Standard deviation of a term of a lens' departure before the pixels are seen.
///
/// The OTF of a lens lies between -0.13 (a disc of defocus) and 1, and that of the parametric lens
/// follows it as well as it can. Pupils, discs, halos and sharpening need terms up to 0.17. Pixels
/// tell a term to some thousandths where the box of the pixel lets light pass, so this matters only
/// where nothing is seen, and there it keeps the OTF within what lenses have.
pub(crate) const DEPARTURE: f64 = 0.3;

/// Camera of a scene, with the covariance of its lenses.
#[derive(Debug, Clone)]
pub struct Optics {
    /// Box of a pixel, and the most likely lens, along each direction in which it was measured.
    pub camera: Camera,
    /// Numbers of the lenses that are estimated, see [`Camera::numbers`]: all but exponents of 2.
    pub free: Vec<usize>,
    /// Values of these numbers.
    pub lens: DVector<f64>,
    /// Covariance of all numbers of the lenses.
    pub covariance: DMatrix<f64>,
    /// True if there is no reference. Lens and covariance are then assumed.
    pub assumed: bool,
}

impl Optics {
    /// Returns the optics of a camera that no reference shows: the median lens, and how much lenses
    /// differ.
    pub(crate) fn assumed(pitch_mm: f64) -> Optics {
        let lens = DVector::from_vec(vec![ln_blur(ASSUMED_PX, pitch_mm)]);
        let variance = ASSUMED_FACTOR.ln().powi(2);
        Optics {
            camera: at(&gaussian(pitch_mm), &[0], &lens),
            free: vec![0],
            lens,
            covariance: DMatrix::from_row_slice(2, 2, &[variance, 0.0, 0.0, 0.0]),
            assumed: true,
        }
    }

    /// Returns the camera whose lenses have these values of the numbers that are estimated.
    pub(crate) fn at(&self, values: &DVector<f64>) -> Camera {
        at(&self.camera, &self.free, values)
    }

    /// Returns what is known of the estimated numbers before the pixels are seen: the index of
    /// each, with its mean and its standard deviation. Blur and exponent of a measured lens need no
    /// assumption: the pixels of the reference tell them.
    pub(crate) fn priors(&self) -> Vec<(usize, [f64; 2])> {
        if self.assumed {
            return vec![(0, [self.lens[0], self.covariance[(0, 0)].sqrt()])];
        }
        let mut camera = self.camera.clone();
        let free = self.free.iter().enumerate();
        let is_term = |&(_, &number): &(usize, &usize)| {
            let lens = camera.lens_of(number);
            lens.is_some_and(|(lens, _)| lens.departure.is_some())
        };
        free.filter(is_term)
            .map(|(index, _)| (index, [0.0, DEPARTURE]))
            .collect()
    }

    /// Returns the cameras that lie one step of a number of the lenses away, each with the size of
    /// the step, in the order of the covariance. The covariance is carried to the estimates with
    /// them.
    ///
    /// An assumed blur steps by 1.5 deviations. Blurs add as squares, so a derivative would tell
    /// too little of larger blurs. With this step a share of 95 % lies within 1.96 standard errors,
    /// as for a normal number.
    pub(crate) fn neighbours(&self) -> Vec<(Camera, f64)> {
        let first = if self.assumed {
            1.5 * self.covariance[(0, 0)].sqrt()
        } else {
            STEP
        };
        let neighbour = |number: usize| {
            let step = if number == 0 { first } else { STEP };
            let mut camera = self.camera.clone();
            if let Some((lens, own)) = camera.lens_of(number) {
                match (&mut lens.departure, number - own) {
                    (Some(departure), term) => departure.terms[term] += step,
                    (None, 0) => lens.blur_mm *= step.exp(),
                    (None, _) => lens.exponent += step,
                }
            }
            (camera, step)
        };
        (0..self.camera.numbers()).map(neighbour).collect()
    }
}

/// Returns ln(blur / mm) of a Gaussian with this standard deviation: 1/f0 = sqrt 2 pi sigma.
pub(crate) fn ln_blur(sigma_px: f64, pitch_mm: f64) -> f64 {
    (std::f64::consts::SQRT_2 * std::f64::consts::PI * sigma_px * pitch_mm).ln()
}

/// Returns a camera with a Gaussian lens of one pixel.
pub(crate) fn gaussian(pitch_mm: f64) -> Camera {
    Camera {
        pitch_mm,
        lenses: vec![Lens::new(pitch_mm, 2.0)],
    }
}

/// Returns a camera like this one, whose lenses have other values of these numbers.
pub(crate) fn at(camera: &Camera, numbers: &[usize], values: &DVector<f64>) -> Camera {
    let mut camera = camera.clone();
    let pitch_mm = camera.pitch_mm;
    for (&number, &value) in numbers.iter().zip(values) {
        let Some((lens, first)) = camera.lens_of(number) else {
            continue;
        };
        match (&mut lens.departure, number - first) {
            (Some(departure), term) => departure.terms[term] = value,
            // The blur is at least a thousandth of a pixel, which is no blur, and at most 100
            // pixels, which is no camera.
            (None, 0) => lens.blur_mm = value.exp().clamp(1e-3 * pitch_mm, 100.0 * pitch_mm),
            (None, _) => lens.exponent = value.clamp(0.5, 4.0),
        }
    }
    camera
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{LN_2, PI, SQRT_2};

    /// A lens that nobody measured blurs by a normal spread of half a pixel, or by twice as much or
    /// half as much as one standard deviation. Its neighbour is 1.5 deviations wider, and one with
    /// another exponent 1e-4 away.
    #[test]
    fn an_assumed_lens_is_half_a_pixel_times_or_over_2() {
        let optics = Optics::assumed(0.08);
        let blur_mm = SQRT_2 * PI * 0.5 * 0.08;
        let priors = optics.priors();
        assert_eq!((priors.len(), priors[0].0), (1, 0));
        let [mean, deviation] = priors[0].1;
        assert!((mean - blur_mm.ln()).abs() < 1e-14 && (deviation - LN_2).abs() < 1e-14);
        let neighbours = optics.neighbours();
        let wider = [
            (blur_mm * 2.0_f64.powf(1.5), 2.0, 1.5 * LN_2),
            (blur_mm, 2.0001, 1e-4),
        ];
        assert_eq!(neighbours.len(), wider.len());
        for ((camera, step), (blur_mm, exponent, by)) in neighbours.into_iter().zip(wider) {
            let lens = &camera.lenses[0];
            assert!((lens.blur_mm / blur_mm - 1.0).abs() < 1e-14, "{lens:?}");
            assert!((lens.exponent - exponent).abs() < 1e-14 && (step - by).abs() < 1e-14);
        }
    }
}
