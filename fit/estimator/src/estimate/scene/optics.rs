//! The camera of a scene, and how well its lens is known: measured on the reference, or assumed.

use nalgebra::{DVector, Matrix2};

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

/// Camera of a scene, with the covariance of its lens.
#[derive(Debug, Clone)]
pub struct Optics {
    /// Box of a pixel, and the most likely lens.
    pub camera: Camera,
    /// Parameters of the lens that are estimated: ln(blur / mm), and the exponent if it is not 2.
    pub lens: DVector<f64>,
    /// Covariance of ln(blur) and of the exponent.
    pub covariance: Matrix2<f64>,
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
            camera: camera_of(pitch_mm, &lens),
            lens,
            covariance: Matrix2::new(variance, 0.0, 0.0, 0.0),
            assumed: true,
        }
    }

    /// Returns mean and standard deviation of ln(blur) if they are assumed. A lens that was
    /// measured needs no assumption: the pixels of the reference tell it.
    pub(crate) fn prior(&self) -> Option<[f64; 2]> {
        let known = [self.lens[0], self.covariance[(0, 0)].sqrt()];
        self.assumed.then_some(known)
    }

    /// Returns the cameras that lie one step of a lens parameter away, each with the size of the
    /// step; ln(blur) is first. The covariance of the lens is carried to the estimates with them.
    ///
    /// An assumed blur steps by 1.5 deviations. Blurs add as squares, so a derivative would tell
    /// too little of larger blurs. With this step a share of 95 % lies within 1.96 standard errors,
    /// as for a normal number.
    pub(crate) fn neighbours(&self) -> Vec<(Camera, f64)> {
        let step = self.prior().map_or(STEP, |[_, deviation]| 1.5 * deviation);
        let Some(lens) = self.camera.lens else {
            return Vec::new();
        };
        let blur = Lens {
            blur_mm: lens.blur_mm * step.exp(),
            ..lens
        };
        let exponent = Lens {
            exponent: lens.exponent + STEP,
            ..lens
        };
        let with = |lens: Lens| Camera {
            lens: Some(lens),
            ..self.camera
        };
        vec![(with(blur), step), (with(exponent), STEP)]
    }
}

/// Returns ln(blur / mm) of a Gaussian with this standard deviation: 1/f0 = sqrt 2 pi sigma.
pub(crate) fn ln_blur(sigma_px: f64, pitch_mm: f64) -> f64 {
    (std::f64::consts::SQRT_2 * std::f64::consts::PI * sigma_px * pitch_mm).ln()
}

/// Makes a camera from lens parameters: ln(blur / mm), and the exponent if it is not 2.
pub(crate) fn camera_of(pitch_mm: f64, parameters: &DVector<f64>) -> Camera {
    let exponent = parameters.get(1).copied().unwrap_or(2.0).clamp(0.5, 4.0);
    // The blur is at least a thousandth of a pixel, which is no blur, and at most 100 pixels, which
    // is no camera.
    let blur_mm = parameters[0].exp().clamp(1e-3 * pitch_mm, 100.0 * pitch_mm);
    Camera {
        pitch_mm,
        lens: Some(Lens { blur_mm, exponent }),
    }
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
        let [mean, deviation] = optics.prior().expect("it is assumed");
        assert!((mean - blur_mm.ln()).abs() < 1e-14 && (deviation - LN_2).abs() < 1e-14);
        let neighbours = optics.neighbours();
        let wider = [
            (blur_mm * 2.0_f64.powf(1.5), 2.0, 1.5 * LN_2),
            (blur_mm, 2.0001, 1e-4),
        ];
        assert_eq!(neighbours.len(), wider.len());
        for ((camera, step), (blur_mm, exponent, by)) in neighbours.into_iter().zip(wider) {
            let lens = camera.lens.expect("it is assumed");
            assert!((lens.blur_mm / blur_mm - 1.0).abs() < 1e-14, "{lens:?}");
            assert!((lens.exponent - exponent).abs() < 1e-14 && (step - by).abs() < 1e-14);
        }
    }
}
