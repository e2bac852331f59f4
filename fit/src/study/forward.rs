//! Speed against error of the estimate: the closed form, and renders by ever more samples.

use std::time::Instant;

use nalgebra::DVector;
use rayon::prelude::*;
use serde::Serialize;
use tables::Table;

use crate::compare::Weights;
use crate::estimate::Layout;
use crate::estimate::Loss;
use crate::estimate::Optimum;
use crate::estimate::Renders;
use crate::estimate::Scene;
use crate::estimate::curve;
use crate::estimate::forward;
use crate::estimate::optimum::optimum;
use crate::estimate::{Choice, Value};
use crate::estimate::{Estimate, estimate};
use crate::numerics::Solution;
use crate::samples::Sampling;
use crate::samples::Sequence;

/// Where renders begin and gradients are compared, as multiples of the closed form's a and c: far
/// off, where the scripts that they are compared with begin (fit/BENCHMARKS.md).
const AWAY: [f64; 2] = [1.75, 7.0 / 12.0];

/// Relative errors of a fit, root mean square over randomisations and incidence angles; null for
/// what the model has not.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Errors {
    /// Of the spreads.
    pub a: Option<f64>,
    /// Of the corner size.
    pub c: Option<f64>,
    /// Of the reflectances.
    pub mu: Option<f64>,
}

/// One forward model timed.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Row {
    /// Samples per pixel.
    pub samples: usize,
    /// How they are spread.
    pub sequence: Sequence,
    /// Samples of one evaluation of all photographs.
    pub samples_in_all: usize,
    /// Median seconds to draw the samples and project them.
    pub seconds_to_draw: f64,
    /// Median seconds of one evaluation: MTFs of all photographs and both derivatives, and their
    /// comparison.
    pub seconds_to_evaluate: f64,
    /// Median seconds from measured photographs and a far start to the estimate and its standard
    /// errors by pixel noise.
    pub seconds: f64,
    /// Most evaluations that an estimate took.
    pub iterations: usize,
    /// Differences from the estimate in closed form.
    pub errors: Errors,
    /// Scatter of the gradient of the mean squared MTF difference by ln a and ln c over the
    /// gradient, at a and c away from the estimate.
    pub gradient_noise: [Option<f64>; 2],
}

/// What a study of forward models says.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Speed {
    /// Photographs.
    pub photographs: usize,
    /// Median seconds of the estimate in closed form.
    pub spectral_seconds: f64,
    /// Median seconds of one evaluation of it.
    pub spectral_seconds_to_evaluate: f64,
    /// Evaluations of it.
    pub spectral_iterations: usize,
    /// Standard errors by the pixels' noise.
    pub pixel_noise: Errors,
    /// Independent randomisations behind every row.
    pub randomisations: u64,
    /// The renders.
    pub rows: Vec<Row>,
}

/// Times the estimate of one candidate by every forward model, with the loss `mtf`.
///
/// # Errors
/// As [`Renders::drawn`].
pub(crate) fn speed(
    scene: &Scene,
    table: &Table,
    choice: Choice,
    samplings: &[Sampling],
    randomisations: u64,
) -> Result<Speed, tables::Error> {
    const REPEATS: u64 = 3;
    let layout = Layout::new(choice, scene.groups.len());
    let closed = || estimate(scene, &Loss::Mtf(scene), optimum(scene, choice));
    let (best, spectral_seconds) = timed(REPEATS, |_| closed());
    let at = &best.solution.parameters;
    let evaluate = || Loss::Mtf(scene).evaluate(&layout, at);
    let (_, spectral_seconds_to_evaluate) = timed(REPEATS, |_| evaluate());
    let mut rows = Vec::new();
    for &sampling in samplings {
        let renders = Renders {
            scene,
            table,
            weights: Weights::Noise,
            sampling,
        };
        rows.push(row(&renders, &layout, &best, randomisations)?);
    }
    Ok(Speed {
        photographs: scene.shots.len(),
        spectral_seconds,
        spectral_seconds_to_evaluate,
        spectral_iterations: best.solution.iterations,
        pixel_noise: pixel_noise(&best),
        randomisations,
        rows,
    })
}

/// One forward model beside the estimate in closed form.
fn row(
    renders: &Renders,
    layout: &Layout,
    best: &Estimate,
    randomisations: u64,
) -> Result<Row, tables::Error> {
    let at = &best.solution.parameters;
    // All renders begin far off, where the peers' loop begins.
    let far = Optimum {
        choice: best.choice,
        solution: Solution {
            parameters: away(layout, at),
            iterations: 0,
            ..best.solution.clone()
        },
        observations: best.residuals,
    };
    let (mut fits, mut gradients, mut samples_in_all) = (Vec::new(), Vec::new(), 0);
    let [mut drawing, mut evaluating, mut fitting] = [const { Vec::new() }; 3];
    for randomisation in 0..randomisations {
        let from = far.clone();
        let start = Instant::now();
        let (fit, _) = renders.by_one_randomisation(from, randomisation)?;
        fitting.push(start.elapsed().as_secs_f64());
        fits.push(fit);
        let start = Instant::now();
        let drawn = renders.drawn(best.choice, randomisation)?;
        drawing.push(start.elapsed().as_secs_f64());
        let start = Instant::now();
        std::hint::black_box(Loss::Mtf(&drawn).evaluate(layout, at));
        evaluating.push(start.elapsed().as_secs_f64());
        gradients.push(gradient(&drawn, layout, &away(layout, at)));
        samples_in_all = forward::samples(&drawn);
    }
    let iterations = fits.iter().map(|f| f.solution.iterations);
    Ok(Row {
        samples: renders.sampling.samples,
        sequence: renders.sampling.sequence,
        samples_in_all,
        seconds_to_draw: median(drawing),
        seconds_to_evaluate: median(evaluating),
        seconds: median(fitting),
        iterations: iterations.max().unwrap_or(0),
        errors: errors(&fits, best),
        gradient_noise: noise(layout, &gradients),
    })
}

fn timed<T>(repeats: u64, mut what: impl FnMut(u64) -> T) -> (T, f64) {
    let mut run = |repeat: u64| {
        let start = Instant::now();
        let result = what(repeat);
        (result, start.elapsed().as_secs_f64())
    };
    let (result, first) = run(0);
    let mut seconds = vec![first];
    seconds.extend((1..repeats).map(|repeat| run(repeat).1));
    (result, median(seconds))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Values of a, c and mu.
fn values(fit: &Estimate) -> [Vec<f64>; 3] {
    let of = |list: &[Value]| list.iter().map(|v| v.value).collect();
    let mu = fit.mu.as_deref().unwrap_or_default();
    [
        of(&fit.spread),
        fit.c_mm.iter().map(|v| v.value).collect(),
        of(mu),
    ]
}

fn errors(fits: &[Estimate], best: &Estimate) -> Errors {
    let exact = values(best);
    let of = |k: usize| {
        let squares: Vec<f64> = fits
            .iter()
            .flat_map(|fit| {
                let own = values(fit);
                let pairs = own[k].iter().zip(&exact[k]);
                pairs
                    .map(|(v, e)| (v / e - 1.0).powi(2))
                    .collect::<Vec<_>>()
            })
            .collect();
        root_mean(&squares)
    };
    Errors {
        a: of(0),
        c: of(1),
        mu: of(2),
    }
}

fn pixel_noise(best: &Estimate) -> Errors {
    let of = |list: &[Value]| {
        let squares = list.iter().map(|v| (v.standard_error / v.value).powi(2));
        root_mean(&squares.collect::<Vec<_>>())
    };
    Errors {
        a: of(&best.spread),
        c: of(best.c_mm.as_slice()),
        mu: best.mu.as_deref().and_then(of),
    }
}

fn root_mean(squares: &[f64]) -> Option<f64> {
    let n = squares.len() as f64;
    (n > 0.0).then(|| (squares.iter().sum::<f64>() / n).sqrt())
}

/// Parameters away from an estimate's.
fn away(layout: &Layout, at: &DVector<f64>) -> DVector<f64> {
    let [by_a, by_c] = AWAY.map(f64::ln);
    at.map_with_location(|i, _, ln| ln + if layout.c() == Some(i) { by_c } else { by_a })
}

/// The gradient of the mean squared MTF difference, as published (not weighted).
fn gradient(scene: &Scene, layout: &Layout, at: &DVector<f64>) -> DVector<f64> {
    let parts: Vec<Vec<(usize, f64)>> = scene
        .shots
        .par_iter()
        .map(|shot| {
            let view = &shot.view;
            let curve = curve(shot, None, layout.choice, layout.blur(at, shot.group));
            let by = curve.by_ln_spread.iter().chain(&curve.by_ln_c);
            let by: Vec<Vec<f64>> = by.cloned().collect();
            let (modelled, slopes) = view.predict(&curve.bins, &by);
            let slope = |slope: &Vec<f64>| {
                let terms = modelled.iter().zip(&view.mtf.modulus).zip(slope);
                let sum: f64 = terms.map(|((m, d), s)| 2.0 * (m - d) * s).sum();
                sum / modelled.len() as f64
            };
            let columns = layout.columns(shot.group).into_iter();
            columns.zip(slopes.iter().map(slope)).collect()
        })
        .collect();
    let mut sum = DVector::zeros(at.len());
    for (column, value) in parts.into_iter().flatten() {
        sum[column] += value;
    }
    sum
}

/// Standard deviation over mean of the gradient by ln a (root mean square over angles) and by ln c.
fn noise(layout: &Layout, gradients: &[DVector<f64>]) -> [Option<f64>; 2] {
    let n = gradients.len() as f64;
    let mean = gradients.iter().sum::<DVector<f64>>() / n;
    let relative = |k: usize| {
        let squares: f64 = gradients.iter().map(|g| (g[k] - mean[k]).powi(2)).sum();
        squares / (n - 1.0) / mean[k].powi(2)
    };
    let (of_c, of_a): (Vec<usize>, Vec<usize>) =
        (0..layout.parameters()).partition(|&k| layout.c() == Some(k));
    [of_a, of_c].map(|columns| root_mean(&columns.into_iter().map(relative).collect::<Vec<_>>()))
}
