//! Summary of trials: efficiency, bias and coverage, each with a standard error.

use serde::Serialize;

use crate::study::refused;
use crate::study::refused::Refused;
use crate::study::trial::{LOSSES, PARAMETERS, Trial};
use estimator::estimate::{Kind, Verdict};

/// Relative bound on c below which a campaign is counted.
///
/// The value is a convention. Below it the model is nearly linear across the errors, as the
/// Cramer-Rao bound and intervals of +-1.96 standard errors assume.
pub const LOOSE: f64 = 0.1;

/// Half width of a 95 % interval, standard errors.
const INTERVAL: f64 = 1.959_964;

/// Mean over campaigns with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Figure {
    /// Mean.
    pub value: f64,
    /// Standard error, which falls with the number of campaigns.
    pub error: f64,
}

/// Errors of one parameter under one loss.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Name of the parameter: c, a or mu.
    pub parameter: &'static str,
    /// Loss that was minimised.
    pub loss: Kind,
    /// Root mean square of the error relative to the Cramer-Rao bound of its campaign.
    pub rmse_over_bound: Figure,
    /// Mean of the error relative to its standard error.
    pub bias_over_standard_error: Figure,
    /// Share of 95 % intervals that contain the truth.
    pub coverage: Figure,
}

/// Summary of a study of drawn campaigns.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// Number of campaigns drawn.
    pub campaigns: usize,
    /// Campaigns that gave no trial, by reason.
    pub refused: Vec<Refused>,
    /// Number of campaigns whose relative bound on c is below [`LOOSE`]. Only these enter the rows.
    pub counted: usize,
    /// Number of counted campaigns in which the camera cut dark pixels off at 0.
    pub cut_off: usize,
    /// One row for each parameter and loss.
    pub rows: Vec<Row>,
    /// Number of counted campaigns by quality of the fit, for each loss.
    pub verdicts: Vec<Verdicts>,
}

/// Numbers of campaigns by quality of the fit under one loss.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Verdicts {
    /// Loss that was minimised.
    pub loss: Kind,
    /// Number of good fits.
    pub good: usize,
    /// Number of strained fits.
    pub strained: usize,
    /// Number of poor fits.
    pub poor: usize,
}

impl Summary {
    /// Sums up the trials and the campaigns that gave none.
    pub fn new(trials: &[Trial], refused: Vec<Refused>) -> Summary {
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
            verdicts: LOSSES
                .into_iter()
                .enumerate()
                .map(|of| verdicts(&counted, of))
                .collect(),
            cut_off: counted.iter().filter(|t| t.cut_off).count(),
            rows,
        }
    }
}

/// Returns whether the relative bound on c of a campaign is below [`LOOSE`].
pub(crate) fn tells(trial: &Trial) -> bool {
    trial.bound[0] < LOOSE * trial.truth[0]
}

fn verdicts(trials: &[&Trial], (k, loss): (usize, Kind)) -> Verdicts {
    let of = |verdict| {
        trials
            .iter()
            .filter(|t| t.fit[k].verdict == verdict)
            .count()
    };
    Verdicts {
        loss,
        good: of(Verdict::Good),
        strained: of(Verdict::Strained),
        poor: of(Verdict::Poor),
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::trial::Quality;
    use estimator::estimate::Chances;

    /// Checks a row by hand. Of four campaigns c is off by 1, -1, 3 and 3 bounds. The squares 1, 1,
    /// 9 and 9 have the mean 5 and the variance 64 / 3, so the mean has the error sqrt(16 / 3), and
    /// its root sqrt(5) has that over 2 sqrt(5). With errors of twice the bound the pulls are 0.5,
    /// -0.5, 1.5 and 1.5: their mean is 0.75, with a variance of 2.75 / 3. With errors of the
    /// bound, half of the intervals hold the truth.
    #[test]
    fn a_row_of_four_campaigns_by_hand() {
        let quality = Quality {
            verdict: Verdict::Good,
            scale: 1.0,
            p_values: Chances {
                chi2: 1.0,
                across: 1.0,
                along: 1.0,
                photograph: 1.0,
                light: 1.0,
            },
        };
        let trial = |off: f64| {
            let bound = [0.01, 0.1, 0.02];
            let truth = [0.3, 4.0, 0.5];
            let found = |by: f64| [0, 1, 2].map(|i| [truth[i] + off * bound[i], by * bound[i]]);
            Trial {
                index: 0,
                photographs: 2,
                electrons: 1e4,
                cut_off: false,
                truth,
                bound,
                found: [found(2.0), found(1.0)],
                fit: [quality; 2],
            }
        };
        let summary = Summary::new(&[1.0, -1.0, 3.0, 3.0].map(trial), Vec::new());
        assert_eq!((summary.campaigns, summary.counted), (4, 4));
        let mut cases = 0;
        for row in &summary.rows {
            let (pull, share) = match row.loss {
                Kind::Edge => (1.0, 0.5),
                _ => (0.5, 1.0),
            };
            for (found, value, error) in [
                (
                    row.rmse_over_bound,
                    5.0_f64.sqrt(),
                    (16.0_f64 / 3.0 / 20.0).sqrt(),
                ),
                (
                    row.bias_over_standard_error,
                    1.5 * pull,
                    pull * (11.0_f64 / 12.0).sqrt(),
                ),
                (
                    row.coverage,
                    share,
                    (share * (1.0_f64 - share) / 4.0).sqrt(),
                ),
            ] {
                assert!((found.value - value).abs() < 1e-12, "{row:?}");
                assert!((found.error - error).abs() < 1e-12, "{row:?}");
                cases += 1;
            }
        }
        assert_eq!(cases, 6 * 3);
    }
}
