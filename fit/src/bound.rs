//! One-sided bounds from the profile likelihood, for what the photographs cannot pin down.

use std::collections::BTreeMap;

use nalgebra::DVector;

use crate::estimate::{Choice, Estimate, estimate, refined, rough, sum_of_squares_with};
use crate::kernel::Kernel;
use crate::loss::Loss;
use crate::report::Bound;
use crate::scene::Scene;
use crate::select::Selection;

/// Relative standard error beyond which an estimate is a number without meaning.
const MEANINGLESS: f64 = 0.5;

/// Confidence of the bounds, and the rise of the sum of squares that it stands for (one-sided, one parameter).
const CONFIDENCE: f64 = 0.95;
const RISE: f64 = 2.706;

/// Bounds of the blur parameters whose error is half of themselves or more: c and roughness at most, a at least (each is the
/// direction in which its blur fades away).
pub fn bounds(scene: &Scene, loss: &Loss, fit: &Estimate) -> BTreeMap<String, Bound> {
    let mut found = BTreeMap::new();
    for i in 0..fit.blur_parameters() {
        let relative = fit.covariance[(i, i)].sqrt() / fit.solution.parameters[i].exp();
        if relative.is_finite() && relative < MEANINGLESS {
            continue;
        }
        found.insert(fit.names[i].clone(), bound(scene, loss, fit, i));
    }
    found
}

/// The bound of a term that the photographs do not need: c where the lobe alone was chosen, a where the shift alone was,
/// from the literal Eq. (1), which has both; likewise a baseline's rough front. `None` where all is there, or the fuller
/// model was no candidate.
pub fn absent(scene: &Scene, selection: &Selection) -> Option<(String, Bound)> {
    let choice = selection.best.choice;
    let (name, with) = match choice.kernel {
        Kernel::Lobe => ("c_mm", Kernel::Eq1),
        Kernel::Shift => ("a_per_mm", Kernel::Eq1),
        Kernel::Saito => ("surface_roughness", Kernel::SaitoSurface),
        _ => return None,
    };
    let rows = &mut selection.compared.iter();
    rows.find(|row| row.choice.kernel == with)?;
    let both = Choice {
        kernel: with,
        // A lobe keeps an a for every angle, or c would make up for what one a cannot; a shift has one bound.
        per_angle_a: choice.kernel == Kernel::Lobe && choice.per_angle_a,
        ..choice
    };
    let loss = &selection.loss;
    let fit = estimate(scene, loss, refined(scene, loss, rough(scene, both)));
    let i = fit.names.iter().position(|own| own == name)?;
    Some((name.into(), bound(scene, loss, &fit, i)))
}

fn bound(scene: &Scene, loss: &Loss, fit: &Estimate, i: usize) -> Bound {
    let unit = fit.reduced_chi2().max(1.0);
    let is_a = fit.names[i].starts_with("a_");
    // c and roughness vanish downwards, so their bound lies above; a vanishes upwards, so its bound lies below. Waves
    // spread either way.
    let wave = fit.choice.kernel == Kernel::Wave;
    let limit = |way| edge(scene, loss, fit, i, way, RISE * unit);
    Bound {
        at_least: (is_a || wave).then(|| limit(-1.0)).flatten(),
        at_most: (!is_a).then(|| limit(1.0)).flatten(),
        confidence: CONFIDENCE,
    }
}

/// Where the profile likelihood of parameter `i` has risen by `rise`, walking up or down; `None` where it never does.
fn edge(scene: &Scene, loss: &Loss, fit: &Estimate, i: usize, way: f64, rise: f64) -> Option<f64> {
    let start = &fit.solution.parameters;
    // The sum of squares at the vanishing end, where the optimum may lie flat.
    let risen = |x: f64, from: &DVector<f64>| {
        let (squares, at) = sum_of_squares_with(scene, loss, fit.choice, from, i, x);
        (squares - fit.chi2 > rise, at)
    };
    // Where nothing depends on a parameter the solver may leave it anywhere: the walk begins within what a photograph
    // could ever show, c = 0.1 um, a = 10^9 and a roughness of 10^-7.
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
