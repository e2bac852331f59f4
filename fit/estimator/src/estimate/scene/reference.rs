//! The reference photograph: the blur of the camera alone, and the brightness of the source.

use nalgebra::{DMatrix, DVector, Matrix2};

use crate::compare::Contrast;
use crate::compare::Pixels;
use crate::compare::View;
use crate::estimate::scene::optics::{Optics, STEP, camera_of, ln_blur};
use crate::model::Camera;
use edges::numerics::{CONVERGED, Solution, least_squares};
use edges::photographs::photo::taken::Taken;

/// Measured reference photograph.
#[derive(Debug, Clone)]
pub struct Reference {
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
    /// Frequency at which the measured MTF falls to one half, 1/mm.
    pub mtf50_per_mm: Option<f64>,
    /// Relation between stored values and light that was taken for the photograph.
    pub transfer: Taken,
}

impl Reference {
    /// Returns whether a photograph of the mid-air edge is sharper than the reference.
    ///
    /// The blur of the sheet only adds to that of the lens. So where the MTF of the reference is
    /// one half, that of a mid-air image is at most one half. The margin allows for the square
    /// pixel, whose MTF depends on the direction of the edge.
    pub fn is_blunter_than(&self, view: &View) -> bool {
        const MARGIN: f64 = 0.1;
        const SURE: f64 = 5.0;
        let at = self.mtf50_per_mm.and_then(|f| view.mtf_at(f));
        at.is_some_and(|[mtf, error]| mtf - 0.5 > MARGIN.max(SURE * error))
    }
}

/// Fall of the sum of squares for which a free exponent is kept. A superfluous exponent reaches it
/// in 1 of 1000 cases.
const KEEP_EXPONENT: f64 = 10.8;

/// Measures the camera by a photograph of the source edge.
pub fn measure(view: &View, pixels: Pixels, exposure: f64) -> (Reference, Optics) {
    let pitch_mm = view.pitch_mm();
    let start = ln_blur(0.5, pitch_mm);
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
    let optics = Optics {
        camera,
        lens: solution.parameters,
        covariance: lens_covariance,
        assumed: false,
    };
    let mut step_by_lens = [0.0; 2];
    for (slope, neighbour) in step_by_lens.iter_mut().zip(optics.neighbours()) {
        *slope = of(neighbour);
    }
    let reference = Reference {
        pixels,
        exposure,
        step: contrast.step / exposure,
        step_relative_error: contrast.variance(&view.profile).sqrt() / contrast.step.abs(),
        step_by_lens,
        reduced_chi2,
        mtf50_per_mm: view.mtf50_per_mm(),
        transfer: Taken::default(),
    };
    (reference, optics)
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
