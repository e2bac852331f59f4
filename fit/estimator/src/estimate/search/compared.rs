//! Photographs compared with a candidate's model, through the photographs' own estimator.

use nalgebra::{DMatrix, DVector};

use crate::compare::Weights;
use crate::estimate::scene::Aerial;
use crate::estimate::search::layout::Choice;
use crate::estimate::search::layout::Layout;
use crate::model::Baseline;
use crate::model::Blur;
use crate::model::Camera;
use crate::model::further::tangential_gain;
use crate::model::{Curve, Model};

/// Model of one photograph with its derivatives.
pub struct Compared {
    /// Modelled edge profile on the photograph's bins.
    pub curve: Curve,
    /// MTF of the modelled profile through the photograph's estimator.
    pub modelled: Vec<f64>,
    /// Differences of the modelled and the measured MTF, without weights.
    pub difference: Vec<f64>,
    /// Derivatives of the MTF by ln spread, ln c and the parameters of further blurs, as far as the
    /// candidate has them.
    pub derivatives: Vec<Vec<f64>>,
}

/// Makes the model of one photograph under a candidate.
pub fn model<'a>(shot: &'a Aerial, choice: Choice) -> Model<'a> {
    Model {
        kernel: choice.kernel,
        shape: choice.shape,
        shift: shot.direction.shift.as_ref(),
        bent: (choice.further.common_errors)
            .then(|| shot.direction.bent())
            .flatten(),
        wave: shot.direction.wave.as_ref().ok(),
        baseline: Baseline::new(
            choice.kernel,
            shot.incidence_deg.to_radians(),
            shot.direction.refractive_index,
            shot.normal(),
        ),
        r_mm: shot.r_mm,
        normal: shot.normal(),
        further: choice.further,
        ghost: shot.ghost,
        haze: None,
        tangential_gain: tangential_gain(
            shot.incidence_deg.to_radians(),
            shot.direction.refractive_index,
        ),
    }
}

/// Evaluates the model's edge profile on a photograph's bins, in closed form or by the photograph's
/// samples. The profile is that seen by `camera`, or by the scene's own camera if `camera` is
/// `None`.
pub fn curve(shot: &Aerial, camera: Option<&Camera>, choice: Choice, blur: Blur) -> Curve {
    let (view, model) = (&shot.view, model(shot, choice));
    match (&shot.sampled, camera) {
        (None, None) => view.curve(&model, blur),
        (None, Some(camera)) => view.curve_by(camera, &model, blur),
        (Some(own), None) => own.curve(&model, blur, view.pitch_mm(), &view.profile),
        (Some(own), Some(camera)) => {
            let own = own.through(camera);
            own.curve(&model, blur, view.pitch_mm(), &view.profile)
        }
    }
}

/// Compares a photograph's MTF with that of a model. [`curve`] explains `camera`.
pub fn compare(shot: &Aerial, camera: Option<&Camera>, choice: Choice, blur: Blur) -> Compared {
    let curve = curve(shot, camera, choice, blur);
    let (modelled, derivatives) = shot.view.predict(&curve.bins, &curve.derivatives);
    let difference: Vec<f64> = modelled
        .iter()
        .zip(&shot.view.mtf.modulus)
        .map(|(m, d)| m - d)
        .collect();
    Compared {
        difference,
        derivatives,
        curve,
        modelled,
    }
}

/// Stacks the weighted differences of photographs, and their derivatives.
pub(crate) fn assemble(
    shots: &[Aerial],
    layout: &Layout,
    parts: &[Compared],
    weights: Weights,
) -> (DVector<f64>, DMatrix<f64>) {
    let rows = parts.iter().map(|p| p.difference.len() - 1).sum();
    let (mut residuals, mut jacobian) = (
        DVector::zeros(rows),
        DMatrix::zeros(rows, layout.parameters()),
    );
    let mut row = 0;
    for (shot, part) in shots.iter().zip(parts) {
        let weighed = |values: &[f64]| shot.view.weigh(weights, values);
        let n = part.difference.len() - 1;
        residuals
            .rows_mut(row, n)
            .copy_from(&weighed(&part.difference));
        for (column, derivative) in layout
            .columns(shot.place)
            .into_iter()
            .zip(&part.derivatives)
        {
            jacobian
                .view_mut((row, column), (n, 1))
                .copy_from(&weighed(derivative));
        }
        row += n;
    }
    (residuals, jacobian)
}
