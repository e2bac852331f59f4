//! One-sided bounds from the profile likelihood, for parameters that the photographs cannot
//! determine.
//!
//! A term that is not in the chosen candidate gets a bound only if the criterion left it out. The
//! criterion does so more often the more noise has hidden the term. Among such photographs a plain
//! bound of 95 % holds less often. So the level of this bound is conditional on the choice
//! (Fithian, Sun and Taylor, Optimal inference after model selection, arXiv 1410.2597): the
//! estimate, in standard deviations, is a normal number below the threshold of the criterion, see
//! `rise_below`.

use std::collections::BTreeMap;

use nalgebra::DVector;
use serde::{Deserialize, Serialize};

use crate::estimate::scene::Scene;
use crate::estimate::search::fitted::{Estimate, estimate};
use crate::estimate::search::layout::Choice;
use crate::estimate::search::loss::Loss;
use crate::estimate::search::optimum::{refined, rough, sum_of_squares_with, tolerance_for};
use crate::estimate::search::select::{CLEAR, Selection};
use edges::names::Kernel;
use edges::names::{ParameterId, ParameterKind};

/// One-sided bound of a parameter at a confidence.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bound {
    /// Lower bound of the parameter.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub at_least: Option<f64>,
    /// Upper bound of the parameter.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub at_most: Option<f64>,
    /// Confidence of the bound, from 0 to 1.
    pub confidence: f64,
}

/// Bounds of an estimate, by parameter.
pub(crate) type Bounds = BTreeMap<ParameterId, Bound>;

/// Relative standard error from which a parameter gets a bound. Two standard errors then reach
/// zero, so the photographs cannot show that the term exists.
const MEANINGLESS: f64 = 0.5;

/// Confidence of the bounds.
pub const CONFIDENCE: f64 = 0.95;
/// Rise of the sum of squares at this confidence (one-sided, one parameter).
pub const RISE: f64 = 2.706;

/// Bounds the blur parameters whose standard error is at least half of their value.
///
/// c and roughness get an upper bound, a gets a lower bound: each in the direction in which its
/// blur vanishes. `unit` is the factor by which a misfit raises the sum of squares: the square of
/// that on the standard errors, which `fit` does not have yet.
pub fn bounds(scene: &Scene, loss: &Loss, fit: &Estimate, unit: f64) -> Bounds {
    let mut found = Bounds::new();
    // A further blur is only there if it is significant.
    for i in 0..fit.kernel_parameters() {
        let relative = (unit * fit.covariance[(i, i)]).sqrt() / fit.solution.parameters[i].exp();
        if relative.is_finite() && relative < MEANINGLESS {
            continue;
        }
        found.insert(fit.parameters[i], bound(scene, loss, fit, i, RISE * unit));
    }
    found
}

/// Bounds a term that the chosen candidate does not have.
///
/// This is c if the lobe alone was chosen, and a if the shift alone was chosen. Both bounds come
/// from the literal Eq. (1), which has both terms. For the baseline `saito` it is the roughness of
/// the front, from `saito-surface`. Returns `None` for other kernels, or if the fuller model was no
/// candidate.
pub fn absent(scene: &Scene, selection: &Selection, unit: f64) -> Option<(ParameterId, Bound)> {
    let choice = selection.best.choice;
    let (kind, with) = match choice.kernel {
        Kernel::Lobe => (ParameterKind::CornerSize, Kernel::Eq1),
        Kernel::Shift => (ParameterKind::APerMm, Kernel::Eq1),
        Kernel::Saito => (ParameterKind::SurfaceRoughness, Kernel::SaitoSurface),
        _ => return None,
    };
    let rows = &mut selection.compared.iter();
    rows.find(|row| row.choice.kernel == with)?;
    let both = Choice {
        kernel: with,
        // With a lobe each incidence keeps its own a; otherwise c would compensate for what one a
        // cannot describe. With a shift, a has one bound.
        per_angle_a: choice.kernel == Kernel::Lobe && choice.per_angle_a,
        ..choice
    };
    let loss = &selection.loss;
    let fit = estimate(scene, loss, refined(scene, loss, rough(scene, both)));
    let id = kind.shared();
    let i = fit.parameters.iter().position(|&own| own == id)?;
    // Fall of the sum of squares by the term, and the fall that the criterion asks for.
    let worth = (selection.best.chi2 - fit.chi2).max(0.0) / unit;
    let threshold = (loss.observations() as f64).ln() + CLEAR;
    let rise = rise_below(worth.sqrt(), threshold.sqrt());
    Some((id, bound(scene, loss, &fit, i, rise * unit)))
}

/// Returns the rise of the sum of squares at the bound of a number that was found at `found`
/// standard deviations from 0 and would have no bound beyond `threshold`.
///
/// The rise is r^2. A normal number about found + r, known to lie below the threshold, lies below
/// `found` with a probability of 5 %. The rise tends to [`RISE`] if the threshold is far.
pub fn rise_below(found: f64, threshold: f64) -> f64 {
    // Any nearer, a bound would lie beyond 30 standard deviations, which has no meaning.
    let room = (threshold - found).max(0.1);
    let below = |x: f64| 0.5 * libm::erfc(-x / std::f64::consts::SQRT_2);
    let share = |r: f64| below(-r) / below(room - r);
    // The share falls as r grows.
    let (mut low, mut high) = (RISE.sqrt(), 36.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if share(middle) > 1.0 - CONFIDENCE {
            low = middle;
        } else {
            high = middle;
        }
    }
    high * high
}

/// Returns the bound of parameter `i` at which the sum of squares has risen by `rise`.
pub fn bound(scene: &Scene, loss: &Loss, fit: &Estimate, i: usize, rise: f64) -> Bound {
    let is_a = fit.parameters[i].kind.fades_upwards();
    // The blur of c and of roughness vanishes downwards, so their bound is an upper one. That of a
    // vanishes upwards, so its bound is a lower one. Waves spread in both cases.
    let wave = fit.choice.kernel.has_waves();
    let limit = |way| edge(scene, loss, fit, i, way, rise);
    Bound {
        at_least: (is_a || wave).then(|| limit(-1.0)).flatten(),
        at_most: (!is_a).then(|| limit(1.0)).flatten(),
        confidence: CONFIDENCE,
    }
}

/// Finds the value at which the profile likelihood of parameter `i` has risen by `rise`, upwards or
/// downwards (`way`). Returns `None` if it never rises so far.
fn edge(scene: &Scene, loss: &Loss, fit: &Estimate, i: usize, way: f64, rise: f64) -> Option<f64> {
    let start = &fit.solution.parameters;
    // A hundredth of the rise moves the bound by half a hundredth of its distance.
    let tolerance = tolerance_for(0.01 * rise, fit.chi2);
    // Compares the sum of squares with that of the fit, whose optimum may be flat at the vanishing
    // end.
    let risen = |x: f64, from: &DVector<f64>| {
        let (squares, at) = sum_of_squares_with(tolerance, scene, loss, fit.choice, from, (i, x));
        (squares - fit.chi2 > rise, at)
    };
    // If nothing depends on a parameter, the solver may leave it anywhere. So the walk begins
    // within the range that a photograph could ever show: c = 0.1 um, a = 10^9 and a roughness of
    // 10^-7.
    let faint: f64 = if fit.choice.kernel.is_baseline() {
        1e-7
    } else {
        1e-4
    };
    let begin = if way > 0.0 {
        start[i].max(faint.ln())
    } else {
        start[i].min(1e9_f64.ln())
    };
    let (mut inside, mut outside) = (begin, None);
    let mut at = start.clone();
    let mut step = 0.2;
    for _ in 0..12 {
        let x = inside + way * step;
        let (beyond, parameters) = risen(x, &at);
        if beyond {
            outside = Some(x);
            break;
        }
        inside = x;
        at = parameters;
        step *= 1.5;
    }
    let mut outside = outside?;
    // A bound is found to 1 % of the parameter.
    while (outside - inside).abs() > 0.01 {
        let middle = 0.5 * (inside + outside);
        let (beyond, _) = risen(middle, &at);
        if beyond {
            outside = middle;
        } else {
            inside = middle;
        }
    }
    Some(outside.exp())
}
