//! The parameters with which a candidate describes the photographs best.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::estimate::scene::Scene;
use crate::estimate::search::layout::Choice;
use crate::estimate::search::layout::Layout;
use crate::estimate::search::loss::Loss;
use crate::estimate::search::start;
use edges::numerics::{CONVERGED, Evaluation, Solution, least_squares, least_squares_from};

/// Optimum of one candidate.
#[derive(Debug, Clone)]
pub struct Optimum {
    /// Candidate that was fitted.
    pub choice: Choice,
    /// Result of the solver. Its parameters are ln c, ln spread, the variances of further blurs and,
    /// for `edge`, those of the lens.
    pub solution: Solution,
    /// Number of independent numbers that were compared.
    pub observations: usize,
}

impl Optimum {
    /// Returns Bayes' criterion, chi^2 / `misfit` + k ln n. k is the number of parameters, and n
    /// that of the independent numbers compared (see [`Loss::observations`]).
    pub fn criterion(&self, misfit: f64) -> f64 {
        let n = self.observations as f64;
        self.solution.sum_of_squares() / misfit + self.solution.parameters.len() as f64 * n.ln()
    }

    /// Returns the sum of squares per degree of freedom.
    pub fn reduced_chi2(&self) -> f64 {
        let parameters = self.solution.parameters.len();
        let freedom = self.observations.saturating_sub(parameters).max(1);
        self.solution.sum_of_squares() / freedom as f64
    }
}

/// Fits one candidate to the MTFs of a scene.
pub fn optimum(scene: &Scene, choice: Choice) -> Optimum {
    let start = rough(scene, choice);
    refined(scene, &Loss::Mtf(scene), start)
}

/// Share by which parameters and sum of squares change at the end of a rough fit.
pub(crate) const ROUGH: f64 = 1e-3;

/// The same of a fit that only tells whether a candidate is far behind another one. It takes half of
/// the steps.
pub(crate) const COARSE: f64 = 3e-2;

/// Fits a candidate to the MTFs to a thousandth.
pub fn rough(scene: &Scene, choice: Choice) -> Optimum {
    rough_from(ROUGH, scene, choice, start::points(scene, choice))
}

/// Fits a candidate to the MTFs from at least one given starting point, until parameters and sum of
/// squares change by less than the share `tolerance`.
pub(crate) fn rough_from(
    tolerance: f64,
    scene: &Scene,
    choice: Choice,
    starts: Vec<start::Start>,
) -> Optimum {
    let all = from_each(tolerance, scene, choice, starts);
    let best = nearest(all.iter()).expect("there is always a starting point");
    best.clone()
}

/// Fits a candidate to the MTFs from each of the given starting points.
pub(crate) fn from_each(
    tolerance: f64,
    scene: &Scene,
    choice: Choice,
    starts: Vec<start::Start>,
) -> Vec<Optimum> {
    // A further blur begins with none.
    let none = vec![0.0; choice.further.count(scene.distances_mm.len())];
    let starts = starts.into_iter().map(|start| (start, none.clone()));
    from_each_with(tolerance, scene, choice, starts.collect())
}

/// Fits a candidate to the MTFs from each of the given starting points, and parameters of its further
/// blurs.
pub(super) fn from_each_with(
    tolerance: f64,
    scene: &Scene,
    choice: Choice,
    starts: Vec<(start::Start, Vec<f64>)>,
) -> Vec<Optimum> {
    let loss = Loss::Mtf(scene);
    let layout = Layout::of(choice, scene);
    let fits = starts.into_par_iter().map(|(start, further)| {
        let spread = |g: usize| start.spread[if choice.per_angle_a { g } else { 0 }].ln();
        let c = choice.kernel.has_c().then(|| start.c_mm.ln());
        let point = c.into_iter().chain((0..layout.spreads).map(spread));
        let point = point.chain(further);
        let point = DVector::from_iterator(layout.parameters(), point);
        let mut solution = least_squares(point, tolerance, |at| loss.evaluate(&layout, at));
        layout.limit(&mut solution.parameters);
        Optimum {
            choice,
            solution,
            observations: loss.observations(),
        }
    });
    fits.collect()
}

/// Fits a candidate by any loss to convergence, from an optimum on the MTFs.
pub fn refined(scene: &Scene, loss: &Loss, from: Optimum) -> Optimum {
    refined_to(CONVERGED, scene, loss, from)
}

/// Fits a candidate by any loss, from an optimum on the MTFs, until parameters and sum of squares
/// change by less than the share `tolerance`.
pub(crate) fn refined_to(tolerance: f64, scene: &Scene, loss: &Loss, from: Optimum) -> Optimum {
    let layout = Layout::of(from.choice, scene);
    let start = loss.start(&from.solution.parameters);
    let refine = |start, now| {
        let mut near = Vec::new();
        let evaluate = |at: &DVector<f64>| loss.evaluate_from(&layout, at, &mut near);
        least_squares_from(start, now, tolerance, evaluate)
    };
    let mut solution = refine(start.clone(), loss.evaluate(&layout, &start));
    if !is_noticed(loss, &layout, &solution.jacobian) {
        let again = noticeable(loss, &layout, &start).map(|(start, now)| refine(start, now));
        let both = std::iter::once(solution).chain(again);
        solution = both.min_by(by_squares).expect("there is always a solution");
    }
    layout.limit(&mut solution.parameters);
    solution.iterations += from.solution.iterations;
    Optimum {
        choice: from.choice,
        solution,
        observations: loss.observations(),
    }
}

/// Returns the fit with the least sum of squares.
pub(crate) fn nearest<'a>(fits: impl Iterator<Item = &'a Optimum>) -> Option<&'a Optimum> {
    fits.min_by(|a, b| by_squares(&a.solution, &b.solution))
}

/// Compares sums of squares. One that is no number, as in a fit that failed, is larger than all.
fn by_squares(a: &Solution, b: &Solution) -> std::cmp::Ordering {
    let squares = |of: &Solution| {
        let squares = of.sum_of_squares();
        if squares.is_nan() {
            f64::INFINITY
        } else {
            squares
        }
    };
    squares(a).total_cmp(&squares(b))
}

/// Returns whether pixels notice c: where `jacobian` was made, a change of c by a factor of e
/// changes chi-square by more than 1. Other losses are not asked.
fn is_noticed(loss: &Loss, layout: &Layout, jacobian: &DMatrix<f64>) -> bool {
    let c = layout.c().filter(|_| matches!(loss, Loss::Edge(_)));
    c.is_none_or(|c| jacobian.column(c).norm() > 1.0)
}

/// Returns another start and its evaluation: the best of a few c that the pixels notice. A fit may
/// lose c, as a start by the MTFs does where the light is uneven. A c that is far too small or too
/// large has no effect and so no slope, and no fit finds back.
fn noticeable(
    loss: &Loss,
    layout: &Layout,
    start: &DVector<f64>,
) -> Option<(DVector<f64>, Evaluation)> {
    // Logarithms of c, mm: corners of 7 um to 1 mm.
    const STEPS: i32 = 11;
    let c = layout.c()?;
    let tried = (0..STEPS).filter_map(|k| {
        let mut at = start.clone();
        at[c] = -0.5 * f64::from(k);
        // The others were found without c. One step brings them near what goes with it.
        let (residuals, jacobian) = loss.evaluate(layout, &at);
        let others = jacobian.remove_column(c);
        if others.ncols() > 0 {
            // There is no factor of numbers that are not finite.
            let normal = others.tr_mul(&others).cholesky()?;
            at -= normal.solve(&others.tr_mul(&residuals)).insert_row(c, 0.0);
        }
        let now = loss.evaluate(layout, &at);
        let squares = now.0.norm_squared();
        (squares.is_finite() && is_noticed(loss, layout, &now.1)).then_some((squares, (at, now)))
    });
    let best = tried.min_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, start)| start)
}

/// Evaluates a candidate by any loss at the parameters of `from`. The sum of squares is an upper
/// limit of the least one.
pub fn unrefined(scene: &Scene, loss: &Loss, from: Optimum) -> Optimum {
    let layout = Layout::of(from.choice, scene);
    let parameters = loss.start(&from.solution.parameters);
    let (residuals, jacobian) = loss.evaluate(&layout, &parameters);
    Optimum {
        solution: Solution {
            parameters,
            residuals,
            jacobian,
            ..from.solution
        },
        observations: loss.observations(),
        ..from
    }
}

/// Fits a candidate with one spread per incidence from an optimum with one spread for all. The sum
/// of squares is at most that of `from`.
pub fn widened(scene: &Scene, loss: &Loss, from: &Optimum) -> Optimum {
    let choice = Choice {
        per_angle_a: true,
        ..from.choice
    };
    let layout = Layout::of(choice, scene);
    let mut start = from.solution.parameters.clone();
    if let Some(spread) = layout.spread(0) {
        let value = start[spread];
        start = start.insert_rows(spread, layout.spreads - 1, value);
    }
    let mut near = Vec::new();
    let mut solution = least_squares(start, CONVERGED, |at| {
        loss.evaluate_from(&layout, at, &mut near)
    });
    layout.limit(&mut solution.parameters);
    Optimum {
        choice,
        solution,
        observations: loss.observations(),
    }
}

/// Returns the tolerance of a fit whose sum of squares, about `squares`, has to be right to `step`.
pub fn tolerance_for(step: f64, squares: f64) -> f64 {
    // A coarser fit ends in the valleys of a model that does not fit, far from the least sum.
    const COARSEST: f64 = 1e-7;
    (step / squares).clamp(CONVERGED, COARSEST)
}

/// Finds the least sum of squares with parameter `fixed` held at `value`, a point of the profile
/// likelihood. Returns it with the parameters there.
///
/// The search ends when parameters and sum of squares change by less than the share `tolerance`.
pub fn sum_of_squares_with(
    tolerance: f64,
    scene: &Scene,
    loss: &Loss,
    choice: Choice,
    from: &DVector<f64>,
    (fixed, value): (usize, f64),
) -> (f64, DVector<f64>) {
    let layout = Layout::of(choice, scene);
    let with = |free: &DVector<f64>| free.clone().insert_row(fixed, value);
    let mut near = Vec::new();
    let mut evaluate = |free: &DVector<f64>| {
        let (residuals, jacobian) = loss.evaluate_from(&layout, &with(free), &mut near);
        (residuals, jacobian.remove_column(fixed))
    };
    let free = from.clone().remove_row(fixed);
    if free.is_empty() {
        return (evaluate(&free).0.norm_squared(), with(&free));
    }
    let solution = least_squares(free, tolerance, evaluate);
    (solution.sum_of_squares(), with(&solution.parameters))
}

/// Evaluates whitened MTF differences and their derivatives at the given logarithms of c and the
/// spreads.
pub fn residuals_at(
    scene: &Scene,
    choice: Choice,
    parameters: &DVector<f64>,
) -> (DVector<f64>, DMatrix<f64>) {
    let layout = Layout::of(choice, scene);
    Loss::Mtf(scene).evaluate(&layout, parameters)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::search::select::{CLEAR, own_mu_limit};
    use crate::model::Further;
    use edges::names::{Kernel, LobeShape};
    use edges::numerics::Stop;

    /// Returns an optimum with residuals 3 and 4 (chi-square 25) among 100 numbers.
    fn of(parameters: usize) -> Optimum {
        Optimum {
            choice: Choice {
                kernel: Kernel::Eq1,
                shape: LobeShape::Radial,
                per_angle_a: false,
                per_angle_mu: false,
                further: Further::NONE,
            },
            solution: Solution {
                parameters: DVector::zeros(parameters),
                residuals: DVector::from_vec(vec![3.0, 4.0]),
                jacobian: DMatrix::zeros(2, parameters),
                iterations: 1,
                stop: Stop::Converged,
            },
            observations: 100,
        }
    }

    /// Compares criteria with chi-square / misfit + k ln n, calculated by hand with ln 100 =
    /// 4.605170185988091 and ln 8 = 2.079441541679836. Each value has at most four roundings of
    /// numbers below 64, whose last digit is 7e-15.
    #[test]
    fn the_criterion_is_chi_square_plus_a_logarithm_for_each_parameter() {
        let allowed = 4.0 * 7.2e-15;
        for (parameters, misfit, expected) in [
            (0, 1.0, 25.0),
            (1, 1.0, 29.605_170_185_988_09),
            (2, 1.0, 34.210_340_371_976_18),
            (3, 2.5, 23.815_510_557_964_27),
        ] {
            let found = of(parameters).criterion(misfit);
            assert!(
                (found - expected).abs() < allowed,
                "{parameters} parameters: {found} {expected}"
            );
        }
        // Three values of mu from eight photographs have two further parameters.
        let found = own_mu_limit(3, 8) - CLEAR;
        assert!((found - 4.158_883_083_359_672).abs() < allowed, "{found}");
    }
}
