//! Study of time against error: the estimate in closed form, and by renders with more and more
//! samples.

use std::time::Instant;

use nalgebra::DVector;
use rayon::prelude::*;
use serde::Serialize;
use tables::Table;

use edges::numerics::Solution;
use estimator::compare::Weights;
use estimator::estimate::Layout;
use estimator::estimate::Loss;
use estimator::estimate::Optimum;
use estimator::estimate::Renders;
use estimator::estimate::Scene;
use estimator::estimate::curve;
use estimator::estimate::search::forward;
use estimator::estimate::search::optimum::optimum;
use estimator::estimate::{Choice, Value};
use estimator::estimate::{Estimate, estimate};
use estimator::samples::Sampling;
use estimator::samples::Sequence;

/// Point at which renders start and gradients are compared: factors on a and c of the closed form.
/// It lies as far away as the start of the scripts in fit/BENCHMARKS.md.
const AWAY: [f64; 2] = [1.75, 7.0 / 12.0];

/// Relative errors of a fit, root mean square over randomisations and incidence angles; `None` for
/// a parameter that the model does not have.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// Relative error of the diffraction spreads a.
    pub a: Option<f64>,
    /// Relative error of the corner size c.
    pub c: Option<f64>,
    /// Relative error of the reflectances mu.
    pub mu: Option<f64>,
}

/// Times and errors of one forward model.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Samples per pixel.
    pub samples: usize,
    /// Sequence of the samples.
    pub sequence: Sequence,
    /// Samples of one evaluation of all photographs.
    pub samples_in_all: usize,
    /// Median seconds to draw and project the samples.
    pub seconds_to_draw: f64,
    /// Median seconds of one evaluation: MTFs of all photographs, both derivatives, and the
    /// comparison.
    pub seconds_to_evaluate: f64,
    /// Median seconds from measured photographs and a far start to the estimate with its standard
    /// errors from pixel noise.
    pub seconds: f64,
    /// Largest number of evaluations that an estimate took.
    pub iterations: usize,
    /// Differences from the estimate in closed form.
    pub errors: Errors,
    /// Scatter of the gradient of the mean squared MTF difference by ln a and by ln c, relative to
    /// the gradient, at a point away from the estimate.
    pub gradient_noise: [Option<f64>; 2],
}

/// Result of a study of forward models.
#[derive(Debug, Clone, Serialize)]
pub struct Speed {
    /// Number of photographs.
    pub photographs: usize,
    /// Median seconds of the estimate in closed form.
    pub spectral_seconds: f64,
    /// Median seconds of one evaluation in closed form.
    pub spectral_seconds_to_evaluate: f64,
    /// Number of evaluations of the estimate in closed form.
    pub spectral_iterations: usize,
    /// Relative standard errors from the noise of the pixels.
    pub pixel_noise: Errors,
    /// Number of independent randomisations behind each row.
    pub randomisations: u64,
    /// One row for each render.
    pub rows: Vec<Row>,
}

/// Times the estimate of one candidate by each forward model, with the loss `mtf`.
///
/// # Errors
/// Returns the error of [`Renders::drawn`] if the table does not give samples.
pub fn speed(
    scene: &Scene,
    table: &Table,
    choice: Choice,
    samplings: &[Sampling],
    randomisations: u64,
) -> Result<Speed, tables::Error> {
    const REPEATS: u64 = 3;
    let layout = Layout::of(choice, scene);
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

/// Times one forward model and compares it with the estimate in closed form.
fn row(
    renders: &Renders,
    layout: &Layout,
    best: &Estimate,
    randomisations: u64,
) -> Result<Row, tables::Error> {
    let at = &best.solution.parameters;
    // All renders start as far away as the published loop does.
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

/// Returns the values of a, c and mu.
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

/// Returns the parameters of an estimate, moved by the factors of [`AWAY`].
fn away(layout: &Layout, at: &DVector<f64>) -> DVector<f64> {
    let [by_a, by_c] = AWAY.map(f64::ln);
    at.map_with_location(|i, _, ln| ln + if layout.c() == Some(i) { by_c } else { by_a })
}

/// Computes the gradient of the mean squared MTF difference, without weights as in the paper.
fn gradient(scene: &Scene, layout: &Layout, at: &DVector<f64>) -> DVector<f64> {
    let parts: Vec<Vec<(usize, f64)>> = scene
        .shots
        .par_iter()
        .map(|shot| {
            let view = &shot.view;
            let curve = curve(shot, None, layout.choice, layout.blur(at, shot.place));
            let (modelled, slopes) = view.predict(&curve.bins, &curve.derivatives);
            let slope = |slope: &Vec<f64>| {
                let terms = modelled.iter().zip(&view.mtf.modulus).zip(slope);
                let sum: f64 = terms.map(|((m, d), s)| 2.0 * (m - d) * s).sum();
                sum / modelled.len() as f64
            };
            let columns = layout.columns(shot.place).into_iter();
            columns.zip(slopes.iter().map(slope)).collect()
        })
        .collect();
    let mut sum = DVector::zeros(at.len());
    for (column, value) in parts.into_iter().flatten() {
        sum[column] += value;
    }
    sum
}

/// Returns standard deviation over mean of the gradient, by ln a (root mean square over angles) and
/// by ln c.
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
