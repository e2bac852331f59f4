//! The choice of further blurs: one of the camera that the reference does not have, and an angular
//! spread of the sheet.
//!
//! They are tried after the kernel is chosen. At the optimum of a candidate, one evaluation tells
//! by how much a step of Gauss and Newton along their columns would lower the sum of squares. Only
//! where that is near what the criterion asks for, or beats the best candidate, the candidate is
//! fitted with them. Where no candidate describes the photographs, all are fitted with them from
//! their starting points, to the MTFs. So photographs of an ideal sheet through one lens cost one
//! evaluation for each candidate. A further blur is kept if the criterion falls by more than
//! [`CLEAR`] below that of all candidates without one, and if it differs from 0 by [`SURE`] stated
//! errors, which contain that of the lens by every loss. An angular spread has to be a spread: its
//! variance is positive. An own blur that sharpens has to leave an OTF of the lens below 1.
//!
//! At one distance and one incidence both blurs change the photographs alike, and no photograph
//! tells them apart. Then the own blur is taken, and a warning says so (see `verdict`).

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::estimate::scene::Scene;
use crate::estimate::search::cubes::{self, and_more};
use crate::estimate::search::fitted::Estimate;
use crate::estimate::search::layout::{Choice, Layout, Value};
use crate::estimate::search::loss::Loss;
use crate::estimate::search::optimum::{Optimum, nearest, refined, rough};
use crate::estimate::search::score::{Score, possible};
use crate::estimate::search::select::{CLEAR, Candidates, HOPELESS, Ranked, Selection, with_mu};
use crate::model::{Further, OwnBlur};
use edges::numerics::{Solution, Stop};

/// Standard errors by which a variance has to differ from 0.
const SURE: f64 = 3.0;

/// Share of the fall that the criterion asks for, from which on the chosen candidate is fitted with
/// a further blur. The step of Gauss and Newton misses a part of the fall.
pub(super) const PROMISING: f64 = 0.5;

/// Chi-square per degree of freedom from which on a candidate is far from the photographs: its
/// misfit is then as large as the noise.
pub(super) const FAR: f64 = 2.0;

/// Share of a large misfit that a blur has to explain, as a suspect has to.
const EXPLAINED: f64 = 0.5;

/// Fits the candidate `from` with the blurs of `added`, which it does not have. `at` holds its parameters,
/// and those of the lens if the loss has them; `values` starts the parameters of the blurs.
pub(super) fn fitted(
    scene: &Scene,
    loss: &Loss,
    (from, at): (Choice, &DVector<f64>),
    added: Further,
    values: &[[f64; 2]],
) -> Optimum {
    let choice = Choice {
        further: from.further.and(added),
        ..from
    };
    let layout = Layout::of(choice, scene);
    let mut parameters = at.clone();
    for (column, &[value, _]) in layout.columns_of(added).into_iter().zip(values) {
        parameters = parameters.insert_row(column, value);
    }
    // A refinement appends the parameters of the lens itself.
    let start = Optimum {
        choice,
        solution: Solution {
            parameters: parameters.rows(0, layout.parameters()).into_owned(),
            residuals: DVector::zeros(0),
            jacobian: DMatrix::zeros(0, 0),
            iterations: 0,
            stop: Stop::Converged,
        },
        observations: loss.observations(),
    };
    refined(scene, loss, start)
}

/// Returns a candidate that describes the MTFs far better than `from` by a further blur, or `from`
/// itself.
///
/// Noise and light of the pixels are found about this candidate. About one that is far from the
/// photographs, even light would look uneven. A blur that explains little, as where one angle of
/// the manifest is wrong, may be one that sharpens, and would lead farther away.
pub(crate) fn nearer(scene: &Scene, from: &Optimum) -> Optimum {
    if from.reduced_chi2() <= FAR {
        return from.clone();
    }
    let fits = opened(scene, from.choice).filter(|&choice| may_be_taken(scene, choice));
    let fits = fits.map(|choice| rough(scene, choice));
    // Dihedral errors, and blurs of each distance, bend to any mistake; about those that still do not
    // fit, light would look uneven.
    let fits = fits.filter(|fit| {
        let further = fit.choice.further;
        let bends = further.common_errors || further.own_blur == OwnBlur::PerDistance;
        let is_near = !bends || fit.reduced_chi2() <= FAR;
        is_near && explains(from.reduced_chi2(), fit.reduced_chi2())
    });
    let all = fits.chain(std::iter::once(from.clone()));
    let found = all.filter(|fit| fit.criterion(1.0).is_finite());
    found
        .min_by(|a, b| a.criterion(1.0).total_cmp(&b.criterion(1.0)))
        .unwrap_or_else(|| from.clone())
}

/// Returns whether a candidate may be the estimate. A blur of each photograph would bend to any mistake:
/// where distances are not repeated, it is only a rival, whose difference the errors include.
fn may_be_taken(scene: &Scene, choice: Choice) -> bool {
    choice.further.own_blur != OwnBlur::PerDistance || scene.repeats_distances()
}

/// Returns a candidate with each set of further blurs that it may have.
fn opened(scene: &Scene, choice: Choice) -> impl Iterator<Item = Choice> + use<> {
    let possible = possible(scene, choice.kernel);
    let open = TRIED.into_iter().chain([
        Further::COMMON_ERRORS,
        Further::COMMON_ERRORS.and(Further::ANGULAR_SPREAD),
    ]);
    let open = open.filter(move |own| own.are_among(possible));
    open.map(move |further| Choice { further, ..choice })
}

/// Sets of Gaussian blurs that are tried, in the order of preference among equals.
const TRIED: [Further; 4] = [
    Further::OWN_BLUR,
    Further::ANGULAR_SPREAD,
    Further {
        own_blur: OwnBlur::Shared,
        ..Further::ANGULAR_SPREAD
    },
    Further::PER_DISTANCE,
];

/// Criteria of candidates of one selection.
struct Criteria {
    /// Natural logarithm of the number of observations.
    penalty: f64,
    /// Number of parameters of the lens.
    lens: usize,
    observations: usize,
}

impl Criteria {
    fn of(&self, row: &Ranked, misfit: f64) -> f64 {
        row.chi2 / misfit + (row.parameters + self.lens) as f64 * self.penalty
    }

    /// Returns the least sum of squares per degree of freedom, at least 1.
    fn misfit<'r>(&self, rows: impl Iterator<Item = &'r Ranked>) -> f64 {
        let reduced = rows.map(|row| {
            let freedom = self.observations.saturating_sub(row.parameters + self.lens);
            row.chi2 / freedom.max(1) as f64
        });
        reduced.fold(f64::INFINITY, f64::min).max(1.0)
    }
}

/// Tries further blurs for the candidates of a selection, and takes those that the criterion asks
/// for.
pub(crate) fn added<'a>(
    scene: &Scene,
    open: &Candidates,
    selection: Selection<'a>,
) -> Selection<'a> {
    let loss = &selection.loss;
    let criteria = Criteria {
        penalty: (loss.observations() as f64).ln(),
        lens: loss.start(&DVector::zeros(0)).len(),
        observations: loss.observations(),
    };
    let fits = tried(scene, &criteria, &selection);
    if fits.is_empty() {
        return selection;
    }
    let row = |fit: &Optimum| {
        let parameters = Layout::of(fit.choice, scene).parameters();
        Ranked {
            choice: fit.choice,
            criterion: 0.0,
            chi2: fit.solution.sum_of_squares(),
            parameters,
            at: fit.solution.parameters.rows(0, parameters).into_owned(),
        }
    };
    let rows: Vec<Ranked> = fits.iter().map(row).collect();
    let misfit = criteria.misfit(selection.compared.iter().chain(&rows));
    let least = |rows: &mut dyn Iterator<Item = &Ranked>| {
        let all = rows.map(|row| criteria.of(row, misfit));
        all.fold(f64::INFINITY, f64::min)
    };
    let can_be = |row: &Ranked| may_be_taken(scene, row.choice);
    let before = criteria.misfit(selection.compared.iter());
    let explains = |row| explains(before, criteria.misfit(std::iter::once(row)));
    let plain = least(&mut selection.compared.iter());
    let widened = least(&mut rows.iter().filter(|row| can_be(row)));
    let mut order: Vec<usize> = (0..rows.len())
        .filter(|&i| {
            let own = criteria.of(&rows[i], misfit);
            can_be(&rows[i]) && explains(&rows[i]) && own < plain - CLEAR && own <= widened + CLEAR
        })
        .collect();
    // The sort is stable, so equals keep their order of preference.
    order.sort_by_key(|&i| rows[i].parameters);
    let estimates = order
        .into_iter()
        .map(|i| with_mu(scene, loss, open, fits[i].clone()));
    let is_taken = |fit: &Estimate| is_sure(fit) && is_possible(scene, fit);
    let Some(best) = estimates.into_iter().find(is_taken) else {
        return selection;
    };
    let mut compared = selection.compared;
    compared.extend(rows);
    for row in &mut compared {
        row.criterion = criteria.of(row, misfit);
    }
    compared.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
    Selection {
        loss: selection.loss,
        near: selection.near,
        best,
        compared,
    }
}

/// Fits the candidates of a selection with each set of further blurs that is promising.
fn tried(scene: &Scene, criteria: &Criteria, selection: &Selection) -> Vec<Optimum> {
    let Selection {
        loss,
        best,
        compared,
        ..
    } = selection;
    let is_best = |row: &Ranked| {
        let (a, b) = (row.choice, best.choice);
        (a.kernel, a.shape, a.per_angle_a) == (b.kernel, b.shape, b.per_angle_a)
    };
    let misfit = criteria.misfit(compared.iter());
    if misfit > FAR {
        return from_the_start(scene, loss, compared, misfit);
    }
    let least = compared.first().map_or(f64::NAN, |row| row.criterion);
    // The chosen candidate comes first.
    let chosen = compared.iter().filter(|row| is_best(row));
    let others = compared.iter().filter(|row| !is_best(row));
    let hopeful = others.filter(|row| row.criterion <= HOPELESS * least + CLEAR);
    let mut fits: Vec<Optimum> = Vec::new();
    let (mut beaten, mut stepped) = (least, None);
    for row in chosen.chain(hopeful) {
        let at = if is_best(row) {
            best.solution.parameters.clone()
        } else {
            loss.start(&row.at)
        };
        // Of the others nobody asks for dihedral errors, whose columns cost most.
        let mut asked = Further::ALL;
        asked.common_errors = is_best(row);
        let Some(score) = Score::new(scene, loss, (row.choice, &at), asked) else {
            continue;
        };
        let count = |further: Further| further.count(scene.distances_mm.len());
        let penalty = |further: Further| count(further) as f64 * criteria.penalty;
        let is_promising = |further: Further, fall: f64, beaten: f64| {
            let fall = fall / misfit;
            if is_best(row) {
                fall > PROMISING * (penalty(further) + CLEAR)
            } else {
                row.criterion - fall + penalty(further) < beaten
            }
        };
        let errors = Further::COMMON_ERRORS;
        let step = score.step(errors).filter(|_| is_best(row));
        if let Some((_, values)) = step.filter(|&(fall, _)| is_promising(errors, fall, beaten)) {
            stepped = Some(fitted(scene, loss, (row.choice, &at), errors, &values));
        }
        for further in TRIED {
            let Some((fall, variances)) = score.step(further) else {
                continue;
            };
            if !is_promising(further, fall, beaten) {
                continue;
            }
            let fit = fitted(scene, loss, (row.choice, &at), further, &variances);
            if is_found(&fit) {
                beaten = beaten.min(fit.criterion(misfit));
                fits.push(fit);
            }
        }
    }
    let criterion = |fit: &Optimum| fit.criterion(misfit);
    let order = |a: &&Optimum, b: &&Optimum| criterion(a).total_cmp(&criterion(b));
    let blurred = fits.iter().min_by(order).cloned();
    if stepped.is_some() || blurred.is_some() {
        // Errors may look like a spread of each angle.
        let shared = Choice {
            per_angle_a: false,
            ..best.choice
        };
        let choices = [best.choice, shared].into_iter();
        let choices = choices.take(1 + usize::from(best.choice != shared));
        let bent = cubes::bent(scene, choices, blurred.as_ref());
        let bent = bent.into_iter().map(|fit| refined(scene, loss, fit));
        let known = blurred.as_ref().map(|fit| fit.choice);
        let all = blurred.into_iter().chain(stepped).chain(bent);
        let more = with_more(scene, loss, all.filter(is_found).collect(), misfit);
        fits.extend(more.into_iter().filter(|fit| Some(fit.choice) != known));
    }
    fits
}

/// Fits candidates with further blurs where none without describes the photographs: steps from a fit
/// that is far off lead nowhere. All candidates are fitted to the MTFs from their starting points,
/// and by the loss the best few of those that explain enough of the misfit there, until one does not
/// explain enough of `misfit`.
fn from_the_start(scene: &Scene, loss: &Loss, compared: &[Ranked], misfit: f64) -> Vec<Optimum> {
    const FEW: usize = 3;
    // Dihedral errors, which take longest, do not mend a kernel that is so many times farther off.
    const FARTHER: f64 = 10.0;
    let each = compared.par_iter().map(|row| rough(scene, row.choice));
    let each: Vec<f64> = each.map(|fit| fit.reduced_chi2()).collect();
    let plain = each.iter().copied().fold(f64::INFINITY, f64::min);
    let all = compared.iter().flat_map(|row| opened(scene, row.choice));
    let choices: Vec<Choice> = all.filter(|own| !own.further.common_errors).collect();
    let fits = choices.into_par_iter().map(|choice| rough(scene, choice));
    let mut fits: Vec<Optimum> = fits.collect();
    fits.sort_by(|a, b| a.criterion(1.0).total_cmp(&b.criterion(1.0)));
    let near = compared.iter().zip(&each);
    let near = near.filter(|&(_, &own)| own <= FARTHER * plain);
    let shared = near
        .map(|(row, _)| row.choice)
        .filter(|own| !own.per_angle_a);
    fits.extend(cubes::bent(scene, shared, fits.first()));
    fits.retain(|fit| {
        let left = fit.reduced_chi2() - 1.0;
        fit.solution.stop != Stop::Failed && left <= EXPLAINED * (plain - 1.0)
    });
    fits.sort_by(|a, b| a.criterion(1.0).total_cmp(&b.criterion(1.0)));
    let (mut found, mut tried) = (Vec::new(), Vec::new());
    for fit in fits {
        if !tried.contains(&fit.choice) {
            if tried.len() == FEW {
                break;
            }
            tried.push(fit.choice);
        }
        let fit = refined(scene, loss, fit);
        if !is_found(&fit) {
            continue;
        }
        // By the MTFs, those that follow are farther off still.
        if !explains(misfit, fit.reduced_chi2()) {
            break;
        }
        found.push(fit);
    }
    with_more(scene, loss, found, 1.0)
}

/// Returns the nearest fit of each candidate, and that with a blur more if it is promising.
fn with_more(scene: &Scene, loss: &Loss, mut fits: Vec<Optimum>, misfit: f64) -> Vec<Optimum> {
    let mut found = Vec::new();
    while let Some(fit) = nearest(fits.iter()).cloned() {
        fits.retain(|other| other.choice != fit.choice);
        found.extend(and_more(scene, loss, &fit, misfit));
        found.push(fit);
    }
    found
}

/// Returns whether a fit has an end.
pub(super) fn is_found(fit: &Optimum) -> bool {
    fit.solution.stop != Stop::Failed && fit.solution.sum_of_squares().is_finite()
}

/// Returns whether terms that leave the misfit `left` explain the misfit `before`. A mistake in
/// the manifest also leaves what further terms lessen a little. Of a large misfit they have to
/// explain half.
pub(super) fn explains(before: f64, left: f64) -> bool {
    before <= FAR || left - 1.0 <= EXPLAINED * (before - 1.0)
}

/// Returns whether a lens can be as much sharper than that of the reference as an estimate says, or
/// less by one of its errors: no lens has an OTF above 1. What asks for more is no lens, but
/// spots of light, a tone curve, or sharpening of the mid-air photographs.
fn is_possible(scene: &Scene, fit: &Estimate) -> bool {
    const PER_PX: f64 = 0.25;
    let camera = &scene.optics.camera;
    let lens = |normal_rad: f64| camera.along(normal_rad).lens(PER_PX / camera.pitch_mm);
    let mut shots = scene.shots.iter();
    shots.all(|shot| {
        let own = fit.own_blur_at(shot.place);
        let Some(own) = own.filter(|own| own.value < 0.0) else {
            return true;
        };
        let variance = own.value.abs() * (own.value.abs() - 2.0 * own.standard_error);
        let gain = (2.0 * (PI * PER_PX).powi(2) * variance).exp();
        gain * lens(shot.pixels.line.normal_rad) <= 1.0
    })
}

/// Returns whether each further blur of an estimate differs from 0 by [`SURE`] standard errors, and
/// an angular spread is one. Blurs of several distances differ from 0 together: each of them adds 3 to
/// the square, so that noise exceeds it as seldom.
fn is_sure(fit: &Estimate) -> bool {
    // The error of a deviation is that of the variance divided by twice the deviation.
    let is_spread = |own: Value| own.value > 2.0 * SURE * own.standard_error;
    let (first, n) = (fit.kernel_parameters(), fit.own_blur_px.len());
    let half = fit.own_blur_px.iter().map(|own| 0.5 * own.value);
    let half = DVector::from_iterator(n, half);
    let covariance = fit.covariance.view((first, first), (n, n)).into_owned();
    let squares = covariance
        .cholesky()
        .map(|factor| half.dot(&factor.solve(&half)));
    let least = SURE.powi(2) + 3.0 * n.saturating_sub(1) as f64;
    (n == 0 || squares.is_some_and(|squares| squares > least))
        && fit.angular_spread_mrad.is_none_or(is_spread)
}
