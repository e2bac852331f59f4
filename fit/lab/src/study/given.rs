//! Study of given photographs: errors of the estimate against the Cramer-Rao bound.

use std::time::Instant;

use serde::Serialize;

use edges::names::Kernel;
use edges::names::ParameterId;
use estimator::Error;
use estimator::estimate::Candidates;
use estimator::estimate::Choice;
use estimator::estimate::Layout;
use estimator::estimate::Progress;
use estimator::estimate::Scene;
use estimator::estimate::Used;
use estimator::estimate::refined;
use estimator::estimate::search::optimum::optimum;
use estimator::estimate::search::select::select;
use estimator::estimate::{Estimate, estimate};
use estimator::estimate::{Kind, Loss};

/// Bounds and errors for the photographs of a campaign.
#[derive(Debug, Clone, Serialize)]
pub struct Study {
    /// Chosen kernel.
    pub kernel: Kernel,
    /// Number of photographs without the reference.
    pub photographs: usize,
    /// Seconds to read and measure all photographs.
    pub seconds_to_measure: f64,
    /// One entry for each parameter.
    pub parameters: Vec<Parameter>,
    /// One entry for each fit that was timed.
    pub fits: Vec<Fit>,
}

/// Estimate of one parameter, with its bound and its standard errors.
#[derive(Debug, Clone, Serialize)]
pub struct Parameter {
    /// Name: c_mm, a_per_mm or a_times_r, mu, with `_at_<incidence>` if there is one per angle.
    pub name: ParameterId,
    /// Estimate with the loss `edge`, in the unit of the parameter.
    pub value: f64,
    /// Cramer-Rao bound at the estimate: no unbiased estimate from these pixels has a smaller
    /// standard deviation.
    pub bound: f64,
    /// Standard error with the loss `edge`.
    pub edge: f64,
    /// Standard error with the loss `mtf`. That of mu can lie below the bound, because the MTFs
    /// assume that the light is even across the edge, and the pixels do not.
    pub mtf: f64,
}

/// Fit of one kernel with one loss.
#[derive(Debug, Clone, Serialize)]
pub struct Fit {
    /// Kernel that was fitted.
    pub kernel: Kernel,
    /// Loss that was minimised.
    pub loss: Kind,
    /// Seconds from measured photographs to the estimate. For `edge` they contain the fit by `mtf`
    /// from which it starts.
    pub seconds: f64,
    /// Sum of squares per degree of freedom.
    pub reduced_chi2: f64,
    /// Standard errors of c and the spreads relative to their bounds (root mean square); `None` for
    /// kernels other than the chosen one.
    pub error_over_bound: Option<f64>,
}

/// Fits one candidate with one loss, from the start to values and standard errors.
pub(crate) fn fit(scene: &Scene, choice: Choice, kind: Kind) -> Estimate {
    let near = optimum(scene, choice);
    let loss = Loss::new(kind, scene, (choice, &near.solution.parameters));
    let best = match kind {
        Kind::Mtf => near,
        Kind::Mse | Kind::Edge => refined(scene, &loss, near),
    };
    estimate(scene, &loss, best)
}

/// Studies given photographs, whose reading and measuring took `seconds_to_measure`.
///
/// # Errors
/// Returns the error of [`select`] if no candidate can be fitted.
pub fn photographs(
    scene: &Scene,
    seconds_to_measure: f64,
    open: &Candidates,
) -> Result<Study, Error> {
    let selection = select(scene, Kind::Edge, open, &Progress::SILENT)?;
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
    let layout = Layout::of(best.choice, scene);
    let at = &best.solution.parameters;
    let bound = joint.information(&layout, at, Used::ByAnyEstimate);
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
