//! The reference photograph: the blur of the camera alone, and the brightness of the source.

use nalgebra::{DMatrix, DVector, Matrix2};

use crate::compare::Contrast;
use crate::compare::Pixels;
use crate::compare::View;
use crate::model::{Camera, Lens};
use crate::numerics::{CONVERGED, Solution, least_squares};
use crate::photographs::photo::taken::Taken;

/// Measured reference photograph.
#[derive(Debug, Clone)]
pub struct Reference {
    /// Camera with its lens.
    pub camera: Camera,
    /// Covariance of ln(blur) and of the exponent.
    pub lens_covariance: Matrix2<f64>,
    /// Fitted parameters of the lens: ln(blur / mm), and the exponent if it is not 2.
    pub lens: DVector<f64>,
    /// Pixels of the reference.
    pub pixels: Pixels,
    /// Exposure of the reference.
    pub exposure: f64,
    /// Bright minus dark plateau of the source edge, per unit of exposure.
    pub step: f64,
    /// Relative standard error of `step`.
    pub step_relative_error: f64,
    /// Derivatives of ln(step) by ln(blur) and by the exponent of the lens.
    pub step_by_lens: [f64; 2],
    /// Whitened sum of squares of the lens fit per degree of freedom. It is about 1 if the lens
    /// model describes the camera.
    pub reduced_chi2: f64,
    /// Relation between stored values and light that was taken for the photograph.
    pub transfer: Taken,
}

/// Fall of the sum of squares for which a free exponent is kept. A superfluous exponent reaches it
/// in 1 of 1000 cases.
const KEEP_EXPONENT: f64 = 10.8;

/// Step of the lens parameters for numerical derivatives.
const STEP: f64 = 1e-4;

/// Measures the camera by a photograph of the source edge.
pub(crate) fn measure(view: &View, pixels: Pixels, exposure: f64) -> Reference {
    let pitch_mm = view.pitch_mm();
    // A Gaussian with sigma of half a pixel has 1/f0 = sqrt 2 pi sigma.
    let start = (std::f64::consts::SQRT_2 * std::f64::consts::PI * 0.5 * pitch_mm).ln();
    let gaussian = fit(view, pitch_mm, DVector::from_vec(vec![start]));
    let free = fit(
        view,
        pitch_mm,
        DVector::from_vec(vec![gaussian.parameters[0], 2.0]),
    );
    let keep = gaussian.sum_of_squares() - free.sum_of_squares() > KEEP_EXPONENT;
    let solution = if keep { free } else { gaussian };
    let parameters = solution.parameters.len();
    let freedom = solution.residuals.len().saturating_sub(parameters).max(1) as f64;
    let reduced_chi2 = solution.sum_of_squares() / freedom;
    let normal = solution.jacobian.transpose() * &solution.jacobian;
    let mut lens_covariance = Matrix2::zeros();
    if let Some(inverse) = normal.try_inverse() {
        lens_covariance
            .view_mut((0, 0), (parameters, parameters))
            .copy_from(&(inverse * reduced_chi2.max(1.0)));
    }
    let camera = camera_of(pitch_mm, &solution.parameters);
    let edge = view.edge_of(&camera);
    let contrast = Contrast::fit(&view.profile, &edge);
    let of = |(camera, step): (Camera, f64)| {
        let pairs = view.edge_of(&camera).into_iter().zip(edge.iter());
        let change: Vec<f64> = pairs.map(|(a, b)| (a - b) / step).collect();
        contrast.relative_change(&change)
    };
    let step_by_lens = camera
        .lens
        .map_or([0.0; 2], |lens| neighbours(camera, lens).map(of));
    Reference {
        camera,
        lens_covariance,
        lens: solution.parameters,
        pixels,
        exposure,
        step: contrast.step / exposure,
        step_relative_error: contrast.variance(&view.profile).sqrt() / contrast.step.abs(),
        step_by_lens,
        reduced_chi2,
        transfer: Taken::default(),
    }
}

impl Reference {
    /// Returns the cameras that lie one step of a lens parameter away, each with the size of the
    /// step. The covariance of the lens is carried to the estimates with them.
    pub fn neighbours(&self) -> Vec<(Camera, f64)> {
        let lens = self.camera.lens;
        lens.map_or_else(Vec::new, |lens| neighbours(self.camera, lens).to_vec())
    }
}

/// Returns the cameras that lie one step of a lens parameter away, ln(blur) first, each with the
/// size of the step.
fn neighbours(camera: Camera, lens: Lens) -> [(Camera, f64); 2] {
    let blur = Lens {
        blur_mm: lens.blur_mm * STEP.exp(),
        ..lens
    };
    let exponent = Lens {
        exponent: lens.exponent + STEP,
        ..lens
    };
    [blur, exponent].map(|lens| {
        let lens = Some(lens);
        (Camera { lens, ..camera }, STEP)
    })
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

fn fit(view: &View, pitch_mm: f64, start: DVector<f64>) -> Solution {
    let residuals = |parameters: &DVector<f64>| {
        let edge = view.edge_of(&camera_of(pitch_mm, parameters));
        let (modelled, _) = view.predict(&edge, &[]);
        let difference: Vec<f64> = modelled
            .iter()
            .zip(&view.mtf.modulus)
            .map(|(m, d)| m - d)
            .collect();
        view.whiten(&difference)
    };
    least_squares(start, CONVERGED, |parameters| {
        let here = residuals(parameters);
        // These are central differences. The model is smooth and its rounding 1e-13, so a step of
        // 1e-4 is accurate to 1e-8.
        let columns: Vec<DVector<f64>> = (0..parameters.len())
            .map(|i| {
                let (mut low, mut high) = (parameters.clone(), parameters.clone());
                low[i] -= STEP;
                high[i] += STEP;
                (residuals(&high) - residuals(&low)) / (2.0 * STEP)
            })
            .collect();
        (here, DMatrix::from_columns(&columns))
    })
}
