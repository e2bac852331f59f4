//! How good the estimates are: against the Cramer-Rao bound on given photographs, and over
//! simulated campaigns.

use std::time::Instant;

use serde::Serialize;

use crate::estimate::Candidates;
use crate::estimate::Choice;
use crate::estimate::Error;
use crate::estimate::Layout;
use crate::estimate::Scene;
use crate::estimate::Used;
use crate::estimate::Watch;
use crate::estimate::optimum::optimum;
use crate::estimate::refined;
use crate::estimate::select::select;
use crate::estimate::{Estimate, estimate};
use crate::estimate::{Kind, Loss};
use crate::names::Kernel;
use crate::names::ParameterId;

/// What the photographs of a campaign allow, and what the losses make of them.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Study {
    /// Terms of the blur.
    pub kernel: Kernel,
    /// Photographs, the reference not counted.
    pub photographs: usize,
    /// Seconds to read and measure all photographs.
    pub seconds_to_measure: f64,
    /// Every parameter.
    pub parameters: Vec<Parameter>,
    /// Every fit that was timed.
    pub fits: Vec<Fit>,
}

/// A parameter: how well it can be known, and how well it is.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Parameter {
    /// c_mm, a_per_mm or a_times_r, mu; `_at_<incidence>` where there is one per angle.
    pub name: ParameterId,
    /// Estimate of the pixels.
    pub value: f64,
    /// The Cramer-Rao bound there: no unbiased estimate from these pixels has a smaller standard
    /// deviation.
    pub bound: f64,
    /// Standard error with `edge`.
    pub edge: f64,
    /// Standard error with `mtf`. It can lie below the bound of mu: the MTFs take the light for
    /// even across the edge, the pixels do not.
    pub mtf: f64,
}

/// One kernel fitted with one loss.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Fit {
    /// Terms of the blur.
    pub kernel: Kernel,
    /// What was minimised.
    pub loss: Kind,
    /// Seconds from measured photographs to the estimate; those of `edge` hold the start by `mtf`.
    pub seconds: f64,
    /// Sum of squares per degree of freedom.
    pub reduced_chi2: f64,
    /// Standard errors of c and the spreads over their bounds (root mean square); `None` for other
    /// kernels than the chosen.
    pub error_over_bound: Option<f64>,
}

/// One candidate fitted with one loss: start, optimum, and everything that follows from it.
pub(crate) fn fit(scene: &Scene, choice: Choice, kind: Kind) -> Estimate {
    let near = optimum(scene, choice);
    let loss = Loss::new(kind, scene, (choice, &near.solution.parameters));
    let best = match kind {
        Kind::Mtf => near,
        Kind::Mse | Kind::Edge => refined(scene, &loss, near),
    };
    estimate(scene, &loss, best)
}

/// Studies given photographs, measured in so many seconds.
///
/// # Errors
/// As [`select`].
pub(crate) fn photographs(
    scene: &Scene,
    seconds_to_measure: f64,
    open: &Candidates,
) -> Result<Study, Error> {
    let selection = select(scene, Kind::Edge, open, &Watch::NOBODY)?;
    let best = &selection.best;
    let with_mtf = fit(scene, best.choice, Kind::Mtf);
    let parameters = parameters(scene, &selection.loss, best, &with_mtf);
    let mut fits = Vec::new();
    for &kernel in &open.kernels {
        let choice = Choice {
            kernel,
            ..best.choice
        };
        for loss in [Kind::Mtf, Kind::Edge] {
            let start = Instant::now();
            let found = fit(scene, choice, loss);
            let seconds = start.elapsed().as_secs_f64();
            fits.push(Fit {
                kernel,
                loss,
                seconds,
                reduced_chi2: found.reduced_chi2(),
                error_over_bound: (kernel == best.choice.kernel)
                    .then(|| over_bound(&found, &parameters)),
            });
        }
    }
    Ok(Study {
        kernel: best.choice.kernel,
        photographs: scene.shots.len(),
        seconds_to_measure,
        parameters,
        fits,
    })
}

fn over_bound(found: &Estimate, parameters: &[Parameter]) -> f64 {
    let n = found.blur_parameters();
    let squares = (0..n)
        .zip(parameters)
        .map(|(i, p)| found.covariance[(i, i)] / p.bound.powi(2));
    (squares.sum::<f64>() / n.max(1) as f64).sqrt()
}

fn parameters(scene: &Scene, loss: &Loss, best: &Estimate, with_mtf: &Estimate) -> Vec<Parameter> {
    let Loss::Edge(joint) = loss else {
        return Vec::new();
    };
    let layout = Layout::new(best.choice, scene.groups.len());
    let at = &best.solution.parameters;
    let bound = joint.information(&layout, at, 1.0, Used::ByAnyEstimate);
    let bound = bound.mu.map_or(bound.blur, |mu| mu.covariance);
    let values = best
        .c_mm
        .iter()
        .chain(&best.spread)
        .chain(best.mu.iter().flatten());
    values
        .zip(&best.parameters)
        .enumerate()
        .map(|(i, (value, &name))| Parameter {
            name,
            value: value.value,
            bound: bound[(i, i)].sqrt() * value.value,
            edge: best.covariance[(i, i)].sqrt(),
            mtf: with_mtf.covariance[(i, i)].sqrt(),
        })
        .collect()
}
