//! Further blurs that a fit leaves open: those that the photographs hint at, the bound of a hidden
//! spread, and the shape of one that was found.
//!
//! A blur that differs from 0 by three errors, and not by what the criterion asks for, is not taken. It may still have moved c by several stated errors, because c and a blur look alike: a step
//! along the blur tells by how much. Then the errors include this step, and a warning names it. The
//! estimate stays, so photographs without a further blur lose nothing but the stated errors of one
//! campaign in some hundred.

use nalgebra::{DMatrix, DVector};

use crate::estimate::scene::Scene;
use crate::estimate::search::bound::{Bound, CONFIDENCE, rise_below};
use crate::estimate::search::fitted::{Estimate, estimate};
use crate::estimate::search::further::SINGLE;
use crate::estimate::search::layout::{Choice, Layout};
use crate::estimate::search::loss::Loss;
use crate::estimate::search::optimum::Optimum;
use crate::estimate::search::score::Score;
use crate::estimate::search::select::CLEAR;
use edges::names::{ParameterId, ParameterKind};
use edges::numerics::Solution;

/// Fall of the sum of squares from which on a blur that is not taken is included in the errors, in the
/// order of [`SINGLE`]: three standard errors, which noise exceeds once in 370. For three errors of
/// dihedral angles this is a chi-square of 14.2.
const HINT: [f64; 3] = [9.0, 9.0, 14.2];

/// Blur that the estimate does not have, and that its errors include.
pub(crate) struct Hint {
    /// Covariance that it adds to the coordinates of the estimate.
    pub scatter: DMatrix<f64>,
    /// What it is, in a sentence; `None` if the photographs do not prefer it.
    pub said: Option<String>,
}

impl Hint {
    /// Returns the hint of a blur with which the coordinates of an estimate would be others.
    pub(super) fn of(fit: &Estimate, coordinates: &[f64], said: Option<String>) -> Option<Hint> {
        let pairs = coordinates.iter().zip(fit.coordinates());
        let change =
            DVector::from_iterator(coordinates.len(), pairs.map(|(other, own)| other - own));
        let scatter = &change * change.transpose();
        let is_finite = scatter.iter().all(|v| v.is_finite());
        is_finite.then_some(Hint { scatter, said })
    }
}

/// Looks for blurs that the pixels do not ask for: returns the bound of a spread, and a blur that they
/// hint at. `unit` is the factor by which a misfit raises the sum of squares.
pub(crate) fn hidden(
    scene: &Scene,
    loss: &Loss,
    fit: &Estimate,
    unit: f64,
) -> (Option<(ParameterId, Bound)>, Option<Hint>) {
    let score = Score::new(scene, loss, fit.choice, &fit.solution.parameters);
    let score = score.as_ref();
    let bound = score.and_then(|score| bound(loss, score, unit));
    let hint = score.and_then(|score| hint(scene, loss, fit, score, unit));
    (bound, hint)
}

/// Returns a blur that the chosen candidate does not have and that the pixels hint at.
fn hint(scene: &Scene, loss: &Loss, fit: &Estimate, score: &Score, unit: f64) -> Option<Hint> {
    let at = &fit.solution.parameters;
    let hints = SINGLE.into_iter().zip(HINT).filter_map(|(further, hint)| {
        let (fall, step) = score.step(further)?;
        let can_be = !further.angular_spread || step[0][0] > 0.0;
        (can_be && fall > hint * unit).then_some((fall / hint, further, step))
    });
    let (_, further, step) = hints.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let choice = Choice {
        further: fit.choice.further.and(further),
        ..fit.choice
    };
    let added = Layout::new(choice, scene.groups.len()).columns_of(further);
    let mut moved = at.clone();
    for (column, &[value, _]) in score.columns(further)?.into_iter().zip(&step) {
        moved += value * score.response.column(column);
    }
    for (&column, &[value, _]) in added.iter().zip(&step) {
        moved = moved.insert_row(column, value);
    }
    let stepped = Optimum {
        choice,
        solution: Solution {
            parameters: moved,
            ..fit.solution.clone()
        },
        observations: loss.observations(),
    };
    let mut other = estimate(scene, loss, stepped).coordinates();
    for &column in added.iter().rev() {
        other.remove(column);
    }
    let [variance, error] = step[0];
    let deviation = variance.abs().sqrt();
    let (error, sign) = (0.5 * unit.sqrt() * error / deviation, variance.signum());
    let what = if further.own_blur {
        let pitch_mm = scene.optics.camera.pitch_mm;
        let px = sign * deviation / pitch_mm;
        format!(
            "a further blur of the mid-air photographs by {px:.2} +- {:.2} px (negative: the \
            reference is less sharp)",
            error / pitch_mm
        )
    } else if further.angular_spread {
        format!("an angular spread of {deviation:.3} +- {error:.3} mrad")
    } else {
        let errors: Vec<f64> = step.iter().map(|[value, _]| *value).collect();
        let errors = edge_by_edge(&errors);
        format!("dihedral angles of all cubes that are off by {errors}")
    };
    let shift = fit.c_mm.map_or(String::new(), |_| {
        format!(
            "It would change c by {:+.1} %. ",
            100.0 * (other[0] - fit.coordinates()[0]).exp_m1()
        )
    });
    let said = format!(
        "the photographs hint at {what}, which may be noise. {shift}The estimate leaves it out, and \
        the standard errors include it. More photographs, at two distances, would tell"
    );
    Hint::of(fit, &other, Some(said))
}

/// Writes dihedral errors at the edges 1, 2 and 3.
pub(crate) fn edge_by_edge(errors_mrad: &[f64]) -> String {
    let errors = errors_mrad.iter().map(|error| format!("{error:+.3}"));
    let errors: Vec<String> = errors.collect();
    format!("{} mrad (edges 1, 2 and 3)", errors.join(", "))
}

/// Bounds an angular spread that the chosen candidate does not have, by the pixels.
///
/// The sum of squares is a parabola of the variance. One evaluation gives its least place and its
/// width. The level of the bound is conditional on the choice, see `search::bound`.
fn bound(loss: &Loss, score: &Score, unit: f64) -> Option<(ParameterId, Bound)> {
    let (_, step) = score.step(SINGLE[1])?;
    let [variance, error] = step[0];
    // A spread below 0 is none.
    let variance = variance.max(0.0);
    let found = variance / error / unit.sqrt();
    let threshold = (loss.observations() as f64).ln() + CLEAR;
    let rise = rise_below(found, threshold.sqrt());
    let bound = Bound {
        at_least: None,
        at_most: Some((variance + error * (rise * unit).sqrt()).sqrt()),
        confidence: CONFIDENCE,
    };
    Some((ParameterKind::AngularSpread.shared(), bound))
}
