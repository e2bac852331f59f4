//! Further blurs that a fit leaves open: those that the photographs hint at, the bound of a hidden
//! spread, and the shape of one that was found.
//!
//! A blur that differs from 0 by three errors, and not by what the criterion asks for, is not taken
//! (of dihedral errors, by as much as noise does once in 5,900 campaigns). It may still have moved c
//! by several stated errors, because c and a blur look alike: a step along the blur tells by how much.
//! Then the errors include this step, and a warning names it. The estimate stays, so photographs
//! without a further blur lose nothing but the stated errors of one campaign in some hundred.

use nalgebra::DMatrix;

use crate::estimate::scene::Scene;
use crate::estimate::search::bound::{Bound, CONFIDENCE, rise_below};
use crate::estimate::search::fitted::{Estimate, estimate};
use crate::estimate::search::layout::{Choice, Layout};
use crate::estimate::search::loss::Loss;
use crate::estimate::search::optimum::Optimum;
use crate::estimate::search::score::Score;
use crate::estimate::search::select::CLEAR;
use crate::model::Further;
use edges::names::{ParameterId, ParameterKind};
use edges::numerics::Solution;

/// Fall of the sum of squares from which on a blur that is not taken is included in the errors, in the
/// order of [`Further::SINGLE`]: three standard errors, which noise exceeds once in 370. Dihedral errors
/// have three parameters and add far more to the error of c: noise exceeds a chi-square of 20 once in
/// 5,900.
const HINT: [f64; 3] = [9.0, 9.0, 20.0];

/// Blur that the estimate does not have, and that its errors include.
pub(crate) struct Hint {
    /// Covariance that it adds to the coordinates of the estimate.
    pub scatter: DMatrix<f64>,
    /// What it is, in a sentence; `None` if the photographs do not prefer it.
    pub said: Option<String>,
}

impl Hint {
    /// Returns the hint of a blur with which an estimate would be `other`. `unit` is the factor by which
    /// a misfit raises squared errors, if those of the other estimate beyond its own are to be included.
    pub(super) fn of(
        fit: &Estimate,
        other: &Estimate,
        unit: Option<f64>,
        said: Option<String>,
    ) -> Option<Hint> {
        let place = |id| other.parameters.iter().position(|own| own == id);
        let places: Vec<Option<usize>> = fit.parameters.iter().map(place).collect();
        let (own, coordinates) = (fit.coordinates(), other.coordinates());
        let further = fit.kernel_parameters()..fit.blur_parameters();
        let change = |i: usize| match places[i] {
            Some(k) => coordinates[k] - own[i],
            // The other one has none of this blur.
            None if further.contains(&i) => -own[i],
            None => 0.0,
        };
        let covariance = |of: &Estimate, i: usize, j: usize| {
            of.covariance[(i, j)] / (of.slopes[i] * of.slopes[j])
        };
        let beyond = |i: usize, j: usize| match places[i].zip(places[j]) {
            Some((k, l)) => covariance(other, k, l) - covariance(fit, i, j),
            None => 0.0,
        };
        let n = own.len();
        let mut scatter = DMatrix::from_fn(n, n, |i, j| change(i) * change(j));
        if let Some(unit) = unit {
            let error = |i: usize| covariance(fit, i, i).sqrt();
            let relative = |i, j| beyond(i, j) / (error(i) * error(j));
            let larger = positive_part(DMatrix::from_fn(n, n, relative))?;
            scatter += DMatrix::from_fn(n, n, |i, j| unit * larger[(i, j)] * error(i) * error(j));
        }
        let is_finite = scatter.iter().all(|v| v.is_finite());
        is_finite.then_some(Hint { scatter, said })
    }
}

/// Returns what is positive of a symmetric matrix, or `None` if it is not finite.
///
/// An estimate with other blurs may know some parameters better, and others less well.
fn positive_part(matrix: DMatrix<f64>) -> Option<DMatrix<f64>> {
    if !matrix.iter().all(|v| v.is_finite()) {
        return None;
    }
    let mut eigen = matrix.symmetric_eigen();
    eigen.eigenvalues.apply(|value| *value = value.max(0.0));
    Some(eigen.recompose())
}

/// Looks for blurs that the pixels do not ask for: returns the bound of a spread, and the blurs that they
/// hint at. `unit` is the factor by which a misfit raises the sum of squares.
pub(crate) fn hidden(
    scene: &Scene,
    loss: &Loss,
    fit: &Estimate,
    unit: f64,
) -> (Option<(ParameterId, Bound)>, Vec<Hint>) {
    let at = (fit.choice, &fit.solution.parameters);
    let Some(score) = Score::new(scene, loss, at, Further::ALL) else {
        return (None, Vec::new());
    };
    let found = Further::SINGLE
        .into_iter()
        .zip(HINT)
        .filter_map(|(further, hint)| {
            let (fall, step) = score.step(further)?;
            let can_be = !further.angular_spread || step[0][0] > 0.0;
            let found = Found {
                further,
                fall: fall / unit,
                step,
            };
            (can_be && found.fall > hint).then_some(found)
        });
    let found: Vec<Found> = found.collect();
    let most = found.iter().map(|own| own.fall).fold(0.0, f64::max);
    let blurs = found.iter().filter(|own| !own.further.common_errors);
    let clearest = blurs.max_by(|a, b| a.fall.total_cmp(&b.fall));
    // Dihedral errors may move c where a blur does not.
    let errors = found.iter().filter(|own| own.further.common_errors);
    let errors = errors.filter(|own| own.fall > most - CLEAR);
    let all = clearest.into_iter().chain(errors);
    let hints = all.filter_map(|own| hint(scene, loss, fit, (&score, own), unit));
    (bound(loss, &score, unit), hints.collect())
}

/// Blur that the pixels hint at.
struct Found {
    further: Further,
    /// Fall of chi-square.
    fall: f64,
    /// Its parameters with their standard errors.
    step: Vec<[f64; 2]>,
}

/// Returns the hint of a blur that the chosen candidate does not have.
fn hint(
    scene: &Scene,
    loss: &Loss,
    fit: &Estimate,
    (score, found): (&Score, &Found),
    unit: f64,
) -> Option<Hint> {
    let at = &fit.solution.parameters;
    let (further, step) = (found.further, &found.step);
    let choice = Choice {
        further: fit.choice.further.and(further),
        ..fit.choice
    };
    let added = Layout::of(choice, scene).columns_of(further);
    let mut moved = at.clone();
    let response = score.response(further)?;
    for (column, &[value, _]) in response.column_iter().zip(step) {
        moved += value * column;
    }
    for (&column, &[value, _]) in added.iter().zip(step) {
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
    let other = estimate(scene, loss, stepped);
    let [variance, error] = step[0];
    let deviation = variance.abs().sqrt();
    let (error, sign) = (0.5 * unit.sqrt() * error / deviation, variance.signum());
    let what = if further.has_own_blur() {
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
            100.0 * (other.coordinates()[0] - fit.coordinates()[0]).exp_m1()
        )
    });
    let said = format!(
        "the photographs hint at {what}, which may be noise. {shift}The estimate leaves it out, and \
        the standard errors include it. More photographs, at two distances, would tell"
    );
    let unit = further.common_errors.then_some(unit);
    Hint::of(fit, &other, unit, Some(said))
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
    let (_, step) = score.step(Further::ANGULAR_SPREAD)?;
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

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;

    /// Matrices with the eigenvectors (0.8, 0.6) and (-0.6, 0.8) and known eigenvalues, with and
    /// without the negative ones. Sums of numbers up to 9 round by less than 1e-14.
    #[test]
    fn the_positive_part_keeps_positive_eigenvalues() {
        let of = |[a, b]: [f64; 2]| {
            let basis = DMatrix::from_row_slice(2, 2, &[0.8, -0.6, 0.6, 0.8]);
            &basis * DMatrix::from_diagonal(&DVector::from_vec(vec![a, b])) * basis.transpose()
        };
        let cases = [
            [9.0, 2.0],
            [9.0, -2.0],
            [-3.0, 1.0],
            [-3.0, -1.0],
            [0.0, 0.0],
        ];
        for values in cases {
            let found = positive_part(of(values)).expect("is finite");
            let expected = of(values.map(|value| value.max(0.0)));
            assert!((found - expected).norm() < 1e-13, "{values:?}");
        }
        assert_eq!(positive_part(of([f64::NAN, 1.0])), None);
        assert_eq!(cases.len(), 5);
    }
}
