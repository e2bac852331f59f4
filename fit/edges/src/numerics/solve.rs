//! Nonlinear least squares: Levenberg-Marquardt on analytic derivatives.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt, TerminationReason};
use nalgebra::{DMatrix, DVector, Dyn, Owned};

/// Residuals and their derivatives at one point. A row is a residual, a column a parameter.
pub type Evaluation = (DVector<f64>, DMatrix<f64>);

/// Reason for the end of an iteration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// Parameters or sum of squares no longer change.
    Converged,
    /// Largest number of evaluations reached.
    IterationLimit,
    /// Residuals that are not finite, or no step found.
    Failed,
}

impl Stop {
    /// Returns the name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Stop::Converged => "converged",
            Stop::IterationLimit => "iteration limit",
            Stop::Failed => "failed",
        }
    }
}

/// Result of an iteration.
#[derive(Debug, Clone)]
pub struct Solution {
    /// Parameters at the end.
    pub parameters: DVector<f64>,
    /// Residuals at these parameters.
    pub residuals: DVector<f64>,
    /// Derivatives at these parameters.
    pub jacobian: DMatrix<f64>,
    /// Number of evaluations of the model.
    pub iterations: usize,
    /// Reason for the end.
    pub stop: Stop,
}

impl Solution {
    /// Returns the sum of squares of the residuals.
    pub fn sum_of_squares(&self) -> f64 {
        self.residuals.norm_squared()
    }
}

struct Problem<F> {
    evaluate: F,
    parameters: DVector<f64>,
    now: Evaluation,
}

impl<F: FnMut(&DVector<f64>) -> Evaluation> LeastSquaresProblem<f64, Dyn, Dyn> for Problem<F> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.now = (self.evaluate)(x);
        self.parameters = x.clone();
    }

    fn params(&self) -> DVector<f64> {
        self.parameters.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        self.now
            .0
            .iter()
            .all(|r| r.is_finite())
            .then(|| self.now.0.clone())
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        self.now
            .1
            .iter()
            .all(|r| r.is_finite())
            .then(|| self.now.1.clone())
    }
}

/// Relative change of the parameters or of the sum of squares below which an iteration has
/// converged.
pub const CONVERGED: f64 = 1e-10;

/// Length of the first step, in units of the scaled length of the parameters (MINPACK's factor, 100
/// by default). A longer step from a rough start can reach a region where a term has faded away
/// together with its derivative.
const STEP_BOUND: f64 = 0.3;

/// Minimises the sum of squares from `start`. The parameters should be of order 1 (logarithms of
/// scales). The iteration ends if the parameters or the sum of squares change by less than the
/// share `tolerance`.
pub fn least_squares(
    start: DVector<f64>,
    tolerance: f64,
    mut evaluate: impl FnMut(&DVector<f64>) -> Evaluation,
) -> Solution {
    let now = evaluate(&start);
    least_squares_from(start, now, tolerance, evaluate)
}

/// Does the same as [`least_squares`] from a start whose evaluation `now` is known.
pub fn least_squares_from(
    start: DVector<f64>,
    now: Evaluation,
    tolerance: f64,
    evaluate: impl FnMut(&DVector<f64>) -> Evaluation,
) -> Solution {
    let problem = Problem {
        evaluate,
        parameters: start,
        now,
    };
    let solver = LevenbergMarquardt::new()
        .with_ftol(tolerance)
        .with_xtol(tolerance)
        .with_gtol(1e-12)
        .with_patience(40)
        .with_stepbound(STEP_BOUND);
    let (problem, report) = solver.minimize(problem);
    let stop = match report.termination {
        TerminationReason::Converged { .. }
        | TerminationReason::ResidualsZero
        | TerminationReason::Orthogonal
        | TerminationReason::NoImprovementPossible(_) => Stop::Converged,
        TerminationReason::LostPatience => Stop::IterationLimit,
        _ => Stop::Failed,
    };
    Solution {
        parameters: problem.parameters,
        residuals: problem.now.0,
        jacobian: problem.now.1,
        iterations: report.number_of_evaluations,
        stop,
    }
}
