//! Trials summed up: efficiency, bias and coverage, each with its own error.

use serde::Serialize;

use crate::estimate::Kind;
use crate::study::refused;
use crate::study::refused::Refused;
use crate::study::trial::{LOSSES, PARAMETERS, Trial};

/// Relative bound on c from which a campaign says too little to be counted. A convention: up to
/// there the model is all but linear across the errors, which the Cramer-Rao bound and intervals of
/// +-1.96 standard errors take it for.
pub(crate) const LOOSE: f64 = 0.1;

/// Standard deviations of a 95 % interval.
const INTERVAL: f64 = 1.959_964;

/// A number and its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Figure {
    /// The number.
    pub value: f64,
    /// One standard deviation, by the number of campaigns.
    pub error: f64,
}

/// One parameter under one loss.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Row {
    /// c, a or mu.
    pub parameter: &'static str,
    /// What was minimised.
    pub loss: Kind,
    /// Root-mean-square error over the Cramer-Rao bound, campaign by campaign.
    pub rmse_over_bound: Figure,
    /// Mean error over the standard error.
    pub bias_over_standard_error: Figure,
    /// Share of 95 % intervals that hold the truth.
    pub coverage: Figure,
}

/// What a study says.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Summary {
    /// Campaigns drawn.
    pub campaigns: usize,
    /// Those in which some photograph was refused, by the reason.
    pub refused: Vec<Refused>,
    /// Those whose bound on c is below [`LOOSE`]; the rows are about these.
    pub counted: usize,
    /// Those of them in which the camera cut dark pixels off at 0.
    pub cut_off: usize,
    /// By parameter and loss.
    pub rows: Vec<Row>,
}

impl Summary {
    /// Sums up the trials, beside the campaigns that came to none.
    pub(crate) fn new(trials: &[Trial], refused: Vec<Refused>) -> Summary {
        let counted: Vec<&Trial> = trials.iter().filter(|t| tells(t)).collect();
        let mut rows = Vec::new();
        for (i, parameter) in PARAMETERS.into_iter().enumerate() {
            for (k, loss) in LOSSES.into_iter().enumerate() {
                rows.push(row(&counted, (i, parameter), (k, loss)));
            }
        }
        Summary {
            campaigns: trials.len() + refused::total(&refused),
            refused,
            counted: counted.len(),
            cut_off: counted.iter().filter(|t| t.cut_off).count(),
            rows,
        }
    }
}

/// Whether a campaign's photographs tell c.
pub(crate) fn tells(trial: &Trial) -> bool {
    trial.bound[0] < LOOSE * trial.truth[0]
}

fn row(trials: &[&Trial], (i, parameter): (usize, &'static str), (k, loss): (usize, Kind)) -> Row {
    let error = |t: &Trial| t.found[k][i][0] - t.truth[i];
    let squares: Vec<f64> = trials
        .iter()
        .map(|t| (error(t) / t.bound[i]).powi(2))
        .collect();
    let pulls: Vec<f64> = trials.iter().map(|t| error(t) / t.found[k][i][1]).collect();
    let square = mean(&squares);
    let held = pulls.iter().filter(|p| p.abs() < INTERVAL).count() as f64;
    let n = trials.len().max(1) as f64;
    let share = held / n;
    Row {
        parameter,
        loss,
        rmse_over_bound: Figure {
            value: square.value.sqrt(),
            error: square.error / (2.0 * square.value.sqrt()),
        },
        bias_over_standard_error: mean(&pulls),
        coverage: Figure {
            value: share,
            error: (share * (1.0 - share) / n).sqrt(),
        },
    }
}

fn mean(values: &[f64]) -> Figure {
    let n = values.len().max(1) as f64;
    let value = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - value).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    Figure {
        value,
        error: (variance / n).sqrt(),
    }
}
