//! The search for dihedral errors that all cubes share.
//!
//! To first order the errors do what a change of c does, in proportion to the distance; so a step from
//! cubes without errors finds small ones. Errors whose sum is 0 do nothing to first order in many
//! directions, and large ones move the light of a path by more than its blur. Then steps from 0 lead
//! nowhere. So the errors are fitted to the MTFs from several starting points, and by the loss from the
//! best. The starting points are as large as the angular spread that explains the photographs best:
//! errors e of all edges move the light as a spread of 2 m e does.

use nalgebra::DVector;
use rayon::prelude::*;

use crate::estimate::scene::Scene;
use crate::estimate::search::fitted::{Estimate, estimate};
use crate::estimate::search::further::{PROMISING, SINGLE, fitted, is_found};
use crate::estimate::search::hints::{Hint, edge_by_edge};
use crate::estimate::search::layout::{Choice, Layout};
use crate::estimate::search::loss::Loss;
use crate::estimate::search::optimum::{COARSE, Optimum, nearest, refined};
use crate::estimate::search::score::{Score, possible};
use crate::estimate::search::select::{CLEAR, Ranked};
use crate::model::Further;
use edges::numerics::{Solution, least_squares};

/// Starting points: errors at the edges 1, 2 and 3, in units of their size, with both signs.
const STARTS: [[f64; 3]; 7] = [
    [1.0, 1.0, 1.0],
    [1.7, 0.0, 0.0],
    [0.0, 1.7, 0.0],
    [0.0, 0.0, 1.7],
    [1.2, -1.2, 0.0],
    [0.0, 1.2, -1.2],
    [-1.2, 0.0, 1.2],
];

/// Sizes of the starting points where no angular spread tells it, mrad.
const USUAL_MRAD: f64 = 0.05;

/// Sum of squares of the MTFs from which on errors are far behind a Gaussian blur. The pixels, which know
/// more, would put them farther behind.
const FAR_BEHIND: f64 = 30.0;

/// Dihedral errors and nothing else.
pub(super) const ERRORS: Further = SINGLE[2];

/// Fits dihedral errors to the MTFs: beside the candidate `choice`, and beside that with one spread for
/// all angles. `blurred` is the best fit with a Gaussian blur; what is far behind it is left out.
pub(super) fn bent(
    scene: &Scene,
    compared: &[Ranked],
    (choice, blurred): (Choice, Option<&Optimum>),
) -> Vec<Optimum> {
    let like = |row: &&Ranked| {
        let own = row.choice;
        let is_shared = own.per_angle_a == choice.per_angle_a || !own.per_angle_a;
        own.further == Further::NONE
            && (own.kernel, own.shape) == (choice.kernel, choice.shape)
            && is_shared
            && possible(scene, own.kernel).common_errors
    };
    let of_mtfs = Loss::Mtf(scene);
    let layout = |choice| Layout::new(choice, scene.groups.len());
    let variance = blurred.and_then(|fit| {
        let column = layout(fit.choice).angular_spread()?;
        Some(fit.solution.parameters[column]).filter(|variance| *variance > 0.0)
    });
    let index = scene.shots[0].direction.refractive_index;
    let size_mrad = variance.map_or(USUAL_MRAD, |variance| variance.sqrt() / (2.0 * index));
    let most = blurred.map_or(f64::INFINITY, |fit| {
        let layout = layout(fit.choice);
        let at = fit.solution.parameters.rows(0, layout.parameters());
        let (residuals, _) = of_mtfs.evaluate(&layout, &at.into_owned());
        residuals.norm_squared() + FAR_BEHIND
    });
    let fits = compared.iter().filter(like).take(2);
    let fits = fits.filter_map(|row| from_all_sides(scene, row.choice, &row.at, size_mrad));
    fits.filter(|fit| fit.solution.sum_of_squares() < most)
        .collect()
}

/// Fits a candidate with dihedral errors to the MTFs from all starting points. It has no other further
/// blur; `at` are its parameters without errors.
fn from_all_sides(
    scene: &Scene,
    choice: Choice,
    at: &DVector<f64>,
    size_mrad: f64,
) -> Option<Optimum> {
    let choice = Choice {
        further: ERRORS,
        ..choice
    };
    let layout = Layout::new(choice, scene.groups.len());
    let signs = [1.0, -1.0].into_iter();
    let starts = signs.flat_map(|sign| STARTS.map(|start| start.map(|x| sign * size_mrad * x)));
    let starts: Vec<[f64; 3]> = starts.chain([[0.0; 3]]).collect();
    let loss = Loss::Mtf(scene);
    let fit = |errors: [f64; 3]| {
        let mut start = at.clone().resize_vertically(layout.parameters(), 0.0);
        let first = layout.common_errors().start;
        start.rows_mut(first, 3).copy_from_slice(&errors);
        let mut solution = least_squares(start, COARSE, |at| loss.evaluate(&layout, at));
        layout.limit(&mut solution.parameters);
        Optimum {
            choice,
            solution,
            observations: loss.observations(),
        }
    };
    let fits: Vec<Optimum> = starts.into_par_iter().map(fit).collect();
    nearest(fits.iter()).cloned()
}

/// Returns a fit with a blur more than `fit`, if a step says that the criterion would fall. `misfit` is the
/// factor by which a misfit raises the sum of squares.
pub(super) fn and_more(scene: &Scene, loss: &Loss, fit: &Optimum, misfit: f64) -> Option<Optimum> {
    let at = &fit.solution.parameters;
    let penalty = (loss.observations() as f64).ln();
    let score = Score::new(scene, loss, fit.choice, at)?;
    let steps = SINGLE.into_iter().filter_map(|further| {
        let (fall, values) = score.step(further)?;
        let least = PROMISING * (further.count() as f64 * penalty + CLEAR) * misfit;
        (fall > least).then_some((fall / least, further, values))
    });
    let (_, further, values) = steps.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(fitted(scene, loss, (fit.choice, at), further, &values)).filter(is_found)
}

/// Returns what the errors of an estimate with another further blur have to include: its difference to
/// the best candidate with dihedral errors, unless that has a larger sum of squares by [`CLEAR`]. `unit`
/// is the factor by which a misfit raises the sum of squares.
pub(crate) fn alternative(
    scene: &Scene,
    loss: &Loss,
    (fit, compared): (&Estimate, &[Ranked]),
    unit: f64,
) -> Option<Hint> {
    let own = fit.choice.further;
    if own == Further::NONE || own.common_errors {
        return None;
    }
    // The criteria of the rows ascend.
    let bent = compared
        .iter()
        .find(|row| row.choice.further.common_errors)?;
    let fall = (fit.solution.sum_of_squares() - bent.chi2) / unit;
    if fall.is_nan() || fall < -CLEAR {
        return None;
    }
    let start = Optimum {
        choice: bent.choice,
        solution: Solution {
            parameters: bent.at.clone(),
            ..fit.solution.clone()
        },
        observations: loss.observations(),
    };
    let other = estimate(scene, loss, refined(scene, loss, start));
    let errors = other.dihedral_errors_mrad?.map(|own| own.value);
    let coordinates = other.coordinates();
    let of = |(id, own): (_, f64)| {
        let place = other.parameters.iter().position(|other| other == id);
        place.map_or(own, |place| coordinates[place])
    };
    let pairs = fit.parameters.iter().zip(fit.coordinates());
    let coordinates: Vec<f64> = pairs.map(of).collect();
    let said = format!(
        "dihedral errors that all cubes share would explain the photographs as well as the further \
        blur: {}. The standard errors include the difference. Photographs at more distances, and of \
        edges in two directions, tell them apart",
        edge_by_edge(&errors)
    );
    Hint::of(fit, &coordinates, Some(said))
}
