//! Further blurs that a fit leaves open: those that the photographs hint at, the bound of a hidden
//! spread, and the shape of one that was found.
//!
//! A blur that differs from 0 by [`HINT`] errors, and not by what the criterion asks for, is not
//! taken. It may still have moved c by several stated errors, because c and a blur look alike: a step
//! along the blur tells by how much. Then the errors include this step, and a warning names it. The
//! estimate stays, so photographs without a further blur lose nothing but the stated errors of one
//! campaign in some hundred.
//!
//! An angular spread is a Gaussian, where errors that all cells share send the light to six spots.
//! Small, the two look alike. Larger, the ring in place of the spots (see `crate::model::further`)
//! gives another a. Unless its sum of squares is worse by [`CLEAR`], the errors include the
//! difference of the two estimates.

use nalgebra::{DMatrix, DVector};
use tables::Table;

use crate::estimate::scene::Scene;
use crate::estimate::search::bound::{Bound, CONFIDENCE, rise_below};
use crate::estimate::search::fitted::{Estimate, estimate};
use crate::estimate::search::further::{TRIED, fitted};
use crate::estimate::search::layout::{Choice, Layout};
use crate::estimate::search::loss::Loss;
use crate::estimate::search::optimum::Optimum;
use crate::estimate::search::score::Score;
use crate::estimate::search::select::CLEAR;
use crate::model::Further;
use edges::names::{ParameterId, ParameterKind};
use edges::numerics::{Solution, Stop};

/// Standard errors from which on a blur that is not taken is included in the errors.
const HINT: f64 = 3.0;

/// Blur that the estimate does not have, and that its errors include.
pub(crate) struct Hint {
    /// Covariance that it adds to the coordinates of the estimate.
    pub scatter: DMatrix<f64>,
    /// What it is, in a sentence; `None` if the photographs do not prefer it.
    pub said: Option<String>,
}

impl Hint {
    /// Returns the hint of a blur with which the coordinates of an estimate would be others.
    fn of(fit: &Estimate, coordinates: &[f64], said: Option<String>) -> Option<Hint> {
        let pairs = coordinates.iter().zip(fit.coordinates());
        let change =
            DVector::from_iterator(coordinates.len(), pairs.map(|(other, own)| other - own));
        let scatter = &change * change.transpose();
        let is_finite = scatter.iter().all(|v| v.is_finite());
        is_finite.then_some(Hint { scatter, said })
    }
}

/// Returns the candidate whose spread is a ring, as the spots of errors that all cells share;
/// `None` if the table has such errors itself, or the kernel is that of waves.
pub(crate) fn as_ring(table: &Table, choice: Choice) -> Option<Choice> {
    let exact = table.exact.iter();
    let mut paths = exact.flat_map(|exact| exact.paths.iter().flatten());
    let is_ideal = paths.all(|path| path.deviation == [0.0; 2]);
    (is_ideal && !choice.kernel.has_waves()).then_some(Choice {
        further: Further {
            angular_spread: true,
            is_ring: true,
            ..choice.further
        },
        ..choice
    })
}

/// Says by how much all dihedral angles are off, if the light goes to spots whose variance along an
/// axis is `variance_mrad2`: the root mean square of three errors is sigma / (2 m), see
/// `crate::model::further`.
pub(crate) fn common_errors(table: &Table, variance_mrad2: f64) -> String {
    let index = table.provenance.refractive_index;
    let error_mrad = variance_mrad2.max(0.0).sqrt() / (2.0 * index);
    format!(
        "the dihedral angles of all cubes are off by about {error_mrad:.3} mrad (root mean square): \
        bake tables with such errors (bake design --dihedral-error-mrad) and give them as further \
        --table"
    )
}

/// Fits a ring in place of the angular spread of an estimate. `unit` is the factor by which a misfit
/// raises the sum of squares. Returns `None` if the pixels exclude the ring.
pub(crate) fn spots(
    scene: &Scene,
    table: &Table,
    loss: &Loss,
    fit: &Estimate,
    unit: f64,
) -> Option<Hint> {
    fit.angular_spread_mrad?;
    let choice = as_ring(table, fit.choice)?;
    let ring = fitted(scene, loss, choice, &fit.solution.parameters, &[]);
    let fall = (fit.solution.sum_of_squares() - ring.solution.sum_of_squares()) / unit;
    if ring.solution.stop == Stop::Failed || fall.is_nan() || fall < -CLEAR {
        return None;
    }
    let layout = Layout::new(choice, scene.groups.len());
    let variance_mrad2 = ring.solution.parameters[layout.angular_spread()?];
    let said = (fall > CLEAR).then(|| {
        format!(
            "six spots of light would fit better than an angular spread: {}. The standard errors \
            include the difference",
            common_errors(table, variance_mrad2)
        )
    });
    Hint::of(fit, &estimate(scene, loss, ring).coordinates(), said)
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
    let single = TRIED.into_iter().take(2);
    let hints = single.filter_map(|further| {
        let (fall, step) = score.step(further)?;
        let [variance, error] = step[0];
        let can_be = !further.angular_spread || variance > 0.0;
        (can_be && fall > HINT.powi(2) * unit).then_some((fall, further, variance, error))
    });
    let (_, further, variance, error) = hints.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let choice = Choice {
        further: Further {
            own_blur: further.own_blur || fit.choice.further.own_blur,
            angular_spread: further.angular_spread || fit.choice.further.angular_spread,
            is_ring: fit.choice.further.is_ring,
        },
        ..fit.choice
    };
    let layout = Layout::new(choice, scene.groups.len());
    let added = if further.own_blur {
        layout.own_blur()?
    } else {
        layout.angular_spread()?
    };
    let column = score.columns(further)?[0];
    let moved = at + variance * score.response.column(column);
    let stepped = Optimum {
        choice,
        solution: Solution {
            parameters: moved.insert_row(added, variance),
            ..fit.solution.clone()
        },
        observations: loss.observations(),
    };
    let mut other = estimate(scene, loss, stepped).coordinates();
    other.remove(added);
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
    } else {
        format!("an angular spread of {deviation:.3} +- {error:.3} mrad")
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

/// Bounds an angular spread that the chosen candidate does not have, by the pixels.
///
/// The sum of squares is a parabola of the variance. One evaluation gives its least place and its
/// width. The level of the bound is conditional on the choice, see `search::bound`.
fn bound(loss: &Loss, score: &Score, unit: f64) -> Option<(ParameterId, Bound)> {
    let (_, step) = score.step(TRIED[1])?;
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
