//! Profile likelihoods of an estimate.
//!
//! A profile shows how much worse the best fit becomes if one parameter is moved away from its
//! estimate.

use edges::names::{ParameterId, ParameterKind};
use estimator::estimate::Bound;
use estimator::estimate::Estimated;
use estimator::estimate::{Kind, Loss, sum_of_squares_with, tolerance_for};

/// Greatest number of parameters with a profile: the first ones, if a campaign has many angles.
const MOST: usize = 4;

/// Points on either side of the estimate.
const SIDE: usize = 12;

/// Distance from the estimate to either end of a profile, standard errors.
const REACH: f64 = 3.0;

/// Profile likelihood of one parameter.
#[derive(Debug, Clone)]
pub struct LikelihoodProfile {
    /// The parameter.
    pub id: ParameterId,
    /// Points of the profile: the parameter, and the rise of the least sum of squares.
    ///
    /// The rise is in units of the misfit (chi-square per degree of freedom, at least 1).
    pub points: Vec<[f64; 2]>,
    /// True if the photographs only bound the parameter.
    ///
    /// The points are then spaced logarithmically.
    pub bounded: bool,
}

/// Profiles of an estimate, which a result does not hold.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// Profiles of c, of a spread that all angles share, and of parameters with a bound; at most
    /// four.
    ///
    /// There are none under `mse`, which is no likelihood.
    pub profiles: Vec<LikelihoodProfile>,
}

impl Evidence {
    /// Computes the evidence of a fit.
    ///
    /// At each point of a profile, all other parameters are fitted again by least squares.
    pub fn of(estimated: &Estimated) -> Evidence {
        let (fit, bounds) = (&estimated.best, &estimated.bounds);
        let size = ParameterKind::size_of(fit.choice.kernel);
        let wanted = |i: &usize| {
            let id = &fit.parameters[*i];
            id.kind == size || fit.spread.len() == 1 || bounds.contains_key(id)
        };
        let likelihood = estimated.kind != Kind::Mse;
        let loss = estimated.loss();
        let profiles = (0..fit.kernel_parameters())
            .filter(wanted)
            .take(if likelihood { MOST } else { 0 })
            .map(|i| profile(estimated, &loss, i))
            .collect();
        Evidence { profiles }
    }
}

/// Computes the profile of parameter `i`.
fn profile(estimated: &Estimated, loss: &Loss, i: usize) -> LikelihoodProfile {
    let (scene, fit) = (&estimated.scene, &estimated.best);
    let id = fit.parameters[i];
    let bound: Option<&Bound> = estimated.bounds.get(&id);
    let unit = estimated.goodness.scale.powi(2);
    let estimate = fit.solution.parameters[i];
    let error = fit.covariance[(i, i)].sqrt() / estimate.exp();
    // The solver's parameters are logarithms.
    let [low, high] = match bound.map(|b| (b.at_most, b.at_least)) {
        None => [estimate - REACH * error, estimate + REACH * error],
        // The range begins well inside the allowed values and ends a little beyond the bound.
        Some((Some(most), Some(least))) => [(least / 1.4).ln(), (most * 1.4).ln()],
        Some((Some(most), _)) => [(most / 12.0).ln(), (most * 1.4).ln()],
        Some((_, Some(least))) => [(least / 1.4).ln(), (least * 12.0).ln()],
        Some((None, None)) => [estimate - 2.0, estimate + 2.0],
    };
    let middle = estimate.clamp(low, high);
    // A thousandth of a unit cannot be seen in the plot.
    let tolerance = tolerance_for(1e-3 * unit, fit.chi2);
    let mut points = Vec::with_capacity(2 * SIDE + 1);
    // The points go outwards on both sides. The other parameters start at the values to which the
    // last two points lead.
    for (end, first) in [(low, 0), (high, 1)] {
        let mut last = fit.solution.parameters.clone();
        let mut from = last.clone();
        for k in first..=SIDE {
            let x = middle + (end - middle) * k as f64 / SIDE as f64;
            let (squares, next) =
                sum_of_squares_with(tolerance, scene, loss, fit.choice, &from, (i, x));
            points.push([x.exp(), (squares - fit.chi2) / unit]);
            from = 2.0 * &next - &last;
            last = next;
        }
    }
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    points.dedup_by(|a, b| a[0] == b[0]);
    LikelihoodProfile {
        id,
        points,
        bounded: bound.is_some(),
    }
}
