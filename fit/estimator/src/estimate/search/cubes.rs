//! The search for dihedral errors that all cubes share.
//!
//! To first order the errors do what a change of c does, in proportion to the distance; so a step from
//! cubes without errors finds small ones. Errors whose sum is 0 do nothing to first order in many
//! directions, and large ones move the light of a path by more than its blur. Then steps from 0 lead
//! nowhere. So the OTF is searched for the best c and spread of each of some errors, and the candidate
//! is fitted to the MTFs from the best of them. The minima that this finds are compared by the loss.

use crate::estimate::scene::Scene;
use crate::estimate::search::fitted::{Estimate, estimate};
use crate::estimate::search::further::{PROMISING, fitted, is_found};
use crate::estimate::search::hints::{Hint, edge_by_edge};
use crate::estimate::search::layout::{Choice, Layout};
use crate::estimate::search::loss::Loss;
use crate::estimate::search::optimum::{
    COARSE, Optimum, ROUGH, from_each_with, nearest, refined, refined_to,
};
use crate::estimate::search::score::{Score, possible};
use crate::estimate::search::select::{CLEAR, Ranked};
use crate::estimate::search::start;
use crate::model::Further;
use edges::numerics::Solution;

/// Errors of the search at the edges 1, 2 and 3, in units of their size, with both signs.
const TRIED: [[f64; 3]; 7] = [
    [1.0, 1.0, 1.0],
    [1.7, 0.0, 0.0],
    [0.0, 1.7, 0.0],
    [0.0, 0.0, 1.7],
    [1.2, -1.2, 0.0],
    [0.0, 1.2, -1.2],
    [-1.2, 0.0, 1.2],
];

/// Sizes of the errors of the search, mrad.
const SIZES_MRAD: [f64; 4] = [0.02, 0.06, 0.18, 0.5];

/// Number of errors of the search from which the candidate is fitted. Errors with opposite signs have
/// several minima, and the fourth best start may still lead to a wrong one.
const STARTS: usize = 12;

/// Number of minima that are kept. The pixels may prefer another one than the MTFs, or none.
const MINIMA: usize = 3;

/// Sum of squares of the MTFs from which on errors are far behind a Gaussian blur, or other errors. The
/// pixels, which know more, would put them farther behind.
const FAR_BEHIND: f64 = 30.0;

/// Fits dihedral errors to the MTFs beside each of some candidates without further blurs. What is far
/// behind `blurred`, the best fit with a Gaussian blur, is left out.
pub(super) fn bent(
    scene: &Scene,
    choices: impl Iterator<Item = Choice>,
    blurred: Option<&Optimum>,
) -> Vec<Optimum> {
    let of_mtfs = Loss::Mtf(scene);
    let most = blurred.map_or(f64::INFINITY, |fit| {
        let layout = Layout::of(fit.choice, scene);
        let at = fit.solution.parameters.rows(0, layout.parameters());
        let (residuals, _) = of_mtfs.evaluate(&layout, &at.into_owned());
        residuals.norm_squared() + FAR_BEHIND
    });
    let choices = choices.filter(|own| possible(scene, own.kernel).common_errors);
    let fits = choices.flat_map(|choice| from_all_sides(scene, choice));
    fits.filter(|fit| fit.solution.sum_of_squares() < most)
        .collect()
}

/// Fits a candidate with dihedral errors and no other further blur to the MTFs. Returns its minima, the
/// least first, without those that are far behind it.
fn from_all_sides(scene: &Scene, choice: Choice) -> Vec<Optimum> {
    let choice = Choice {
        further: Further::COMMON_ERRORS,
        ..choice
    };
    let signs = [1.0, -1.0].into_iter();
    let sizes = signs.flat_map(|sign| SIZES_MRAD.map(|size| sign * size));
    let errors = sizes.flat_map(|size| TRIED.map(|errors| errors.map(|x| size * x)));
    let starts = start::bent(scene, choice, errors.collect()).into_iter();
    let starts = starts.take(STARTS);
    let starts = starts.map(|(start, errors)| (start, errors.to_vec()));
    let mut fits = from_each_with(COARSE, scene, choice, starts.collect());
    let squares = |fit: &Optimum| fit.solution.sum_of_squares();
    let mut minima: Vec<Optimum> = Vec::new();
    while let Some(next) = nearest(fits.iter()).cloned() {
        let least = minima.first().map_or(squares(&next), squares);
        if minima.len() == MINIMA || squares(&next) > least + FAR_BEHIND {
            break;
        }
        let fit = refined_to(ROUGH, scene, &Loss::Mtf(scene), next.clone());
        // The MTFs tell the one from the other.
        let is_other = |found: &Optimum, other: &Optimum| {
            let step = &other.solution.parameters - &found.solution.parameters;
            (&found.solution.jacobian * step).norm_squared() > CLEAR
        };
        fits.retain(|other| is_other(&next, other) && is_other(&fit, other));
        if minima.iter().all(|found| is_other(found, &fit)) {
            minima.push(fit);
        }
    }
    minima.sort_by(|a, b| squares(a).total_cmp(&squares(b)));
    minima
}

/// Returns a fit with a blur more than `fit`, if a step says that the criterion would fall. `misfit` is the
/// factor by which a misfit raises the sum of squares.
pub(super) fn and_more(scene: &Scene, loss: &Loss, fit: &Optimum, misfit: f64) -> Option<Optimum> {
    let at = &fit.solution.parameters;
    let penalty = (loss.observations() as f64).ln();
    let score = Score::new(scene, loss, (fit.choice, at), Further::ALL)?;
    let count = |further: Further| further.count(scene.distances_mm.len());
    let more = Further::SINGLE.into_iter().chain([Further::PER_DISTANCE]);
    let steps = more.filter_map(|further| {
        let (fall, values) = score.step(further)?;
        let least = PROMISING * (count(further) as f64 * penalty + CLEAR) * misfit;
        (fall > least).then_some((fall / least, further, values))
    });
    let (_, further, values) = steps.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(fitted(scene, loss, (fit.choice, at), further, &values)).filter(is_found)
}

/// Returns what the errors of an estimate with further blurs have to include: its difference to the best
/// candidate with dihedral errors, or, if it has such errors itself, to the best one with other blurs.
/// A candidate whose sum of squares is larger by [`CLEAR`] does not count, and the errors of one whose
/// sum is smaller are included too. `unit` is the factor by which a misfit raises the sum of squares.
pub(crate) fn alternative(
    scene: &Scene,
    loss: &Loss,
    (fit, compared): (&Estimate, &[Ranked]),
    unit: f64,
) -> Option<Hint> {
    let own = fit.choice.further;
    let is_rival = |row: &&Ranked| {
        let other = row.choice.further;
        other != Further::NONE && other.common_errors != own.common_errors
    };
    // The criteria of the rows ascend.
    let rival = compared.iter().find(is_rival)?;
    let fall = (fit.solution.sum_of_squares() - rival.chi2) / unit;
    if own == Further::NONE || fall.is_nan() || fall < -CLEAR {
        return None;
    }
    let start = Optimum {
        choice: rival.choice,
        solution: Solution {
            parameters: rival.at.clone(),
            ..fit.solution.clone()
        },
        observations: loss.observations(),
    };
    let other = estimate(scene, loss, refined(scene, loss, start));
    let (what, taken) = match other.dihedral_errors_mrad {
        Some(errors) => {
            let errors = edge_by_edge(&errors.map(|own| own.value));
            let what = format!("dihedral errors that all cubes share ({errors})");
            (what, "the further blur")
        }
        None if other.choice.further.has_own_blur() => {
            ("a blur of the camera".into(), "the dihedral errors")
        }
        None => (
            "an angular spread of the sheet".into(),
            "the dihedral errors",
        ),
    };
    let said = format!(
        "{what} would explain the photographs as well as {taken}. The standard errors include the \
        difference. Photographs at more distances, and of edges in two directions, tell them apart"
    );
    Hint::of(fit, &other, (fall > 0.0).then_some(unit), Some(said))
}
