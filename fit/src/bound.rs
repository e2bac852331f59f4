//! One-sided bounds from the profile likelihood, for what the photographs cannot pin down.

use std::collections::BTreeMap;

use nalgebra::DVector;

use crate::estimate::{Estimate, sum_of_squares_with};
use crate::kernel::Kernel;
use crate::loss::Loss;
use crate::report::Bound;
use crate::scene::Scene;

/// Relative standard error beyond which an estimate is a number without meaning.
const MEANINGLESS: f64 = 0.5;

/// Confidence of the bounds, and the rise of the sum of squares that it stands for (one-sided, one parameter).
const CONFIDENCE: f64 = 0.95;
const RISE: f64 = 2.706;

/// Bounds of the blur parameters whose error is half of themselves or more: c at most, spread at least (each is the
/// direction in which its blur fades away).
pub fn bounds(scene: &Scene, loss: &Loss, fit: &Estimate) -> BTreeMap<String, Bound> {
    let mut found = BTreeMap::new();
    let unit = fit.reduced_chi2().max(1.0);
    for i in 0..fit.blur_parameters() {
        let relative = fit.covariance[(i, i)].sqrt() / fit.solution.parameters[i].exp();
        if relative.is_finite() && relative < MEANINGLESS {
            continue;
        }
        let is_c = fit.names[i] == "c_mm";
        // c vanishes downwards, so its bound lies above; a vanishes upwards, so its bound lies below. Waves spread either way.
        let wave = fit.choice.kernel == Kernel::Wave;
        let limit = |way| edge(scene, loss, fit, i, way, RISE * unit);
        let bound = Bound {
            at_least: (!is_c || wave).then(|| limit(-1.0)).flatten(),
            at_most: is_c.then(|| limit(1.0)).flatten(),
            confidence: CONFIDENCE,
        };
        found.insert(fit.names[i].clone(), bound);
    }
    found
}

/// Where the profile likelihood of parameter `i` has risen by `rise`, walking up or down; `None` where it never does.
fn edge(scene: &Scene, loss: &Loss, fit: &Estimate, i: usize, way: f64, rise: f64) -> Option<f64> {
    let start = &fit.solution.parameters;
    // The sum of squares at the vanishing end, where the optimum may lie flat.
    let risen = |x: f64, from: &DVector<f64>| {
        let (squares, at) = sum_of_squares_with(scene, loss, fit.choice, from, i, x);
        (squares - fit.chi2 > rise, at)
    };
    let (mut inside, mut outside) = (start[i], None);
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
    // To 1 % of the parameter: a bound needs no more.
    while (outside - inside).abs() > 0.01 {
        let middle = 0.5 * (inside + outside);
        let (beyond, _) = risen(middle, &at);
        if beyond {
            outside = middle
        } else {
            inside = middle
        }
    }
    Some(outside.exp())
}
