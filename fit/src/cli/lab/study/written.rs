//! The results of drawn campaigns: a table for a reader, and rows of CSV.

use std::fmt::Write;

use lab::study::refused;
use lab::study::{LOOSE, Summary};
use lab::study::{LOSSES, PARAMETERS, Trial};

/// Returns the table of a study of drawn campaigns, for a reader.
pub(super) fn table_of(summary: &Summary) -> String {
    let mut text = format!(
        "{} campaigns: {} counted (bound on c below {:.0} %; in {} of them dark pixels are cut off \
         at 0), {}\n",
        summary.campaigns,
        summary.counted,
        100.0 * LOOSE,
        summary.cut_off,
        refused::line(&summary.refused)
    );
    let _ = writeln!(
        text,
        "{:<4}{:<6}{:>20}{:>24}{:>26}",
        "", "loss", "rmse / bound", "bias / std. error", "coverage of 95 % (%)"
    );
    for row in &summary.rows {
        let (r, b, c) = (
            row.rmse_over_bound,
            row.bias_over_standard_error,
            row.coverage,
        );
        let _ = writeln!(
            text,
            "{:<4}{:<6}{:>13.3} +- {:.3}{:>17.3} +- {:.3}{:>20.2} +- {:.2}",
            row.parameter,
            row.loss.name(),
            r.value,
            r.error,
            b.value,
            b.error,
            100.0 * c.value,
            100.0 * c.error
        );
    }
    for of in &summary.verdicts {
        let _ = writeln!(
            text,
            "fits by {}: {} good, {} strained, {} poor",
            of.loss.name(),
            of.good,
            of.strained,
            of.poor
        );
    }
    text + &refused::examples(&summary.refused)
}

/// Returns one row for each campaign, as CSV.
pub(super) fn spreadsheet(trials: &[Trial]) -> String {
    let mut text = String::from("campaign,photographs,electrons,cut_off");
    for parameter in PARAMETERS {
        let _ = write!(text, ",{parameter},{parameter}_bound");
        for loss in LOSSES {
            let loss = loss.name();
            let _ = write!(
                text,
                ",{parameter}_{loss},{parameter}_{loss}_standard_error"
            );
        }
    }
    for loss in LOSSES {
        let loss = loss.name();
        let _ = write!(
            text,
            ",verdict_{loss},scale_{loss},p_chi2_{loss},p_across_{loss},p_along_{loss},\
            p_photograph_{loss},p_light_{loss}"
        );
    }
    text.push('\n');
    for trial in trials {
        let _ = write!(
            text,
            "{},{},{},{}",
            trial.index, trial.photographs, trial.electrons, trial.cut_off
        );
        for i in 0..PARAMETERS.len() {
            let _ = write!(text, ",{},{}", trial.truth[i], trial.bound[i]);
            for found in &trial.found {
                let _ = write!(text, ",{},{}", found[i][0], found[i][1]);
            }
        }
        for fit in &trial.fit {
            let p = fit.p_values;
            let _ = write!(
                text,
                ",{},{},{},{},{},{},{}",
                fit.verdict.name(),
                fit.scale,
                p.chi2,
                p.across,
                p.along,
                p.photograph,
                p.light
            );
        }
        text.push('\n');
    }
    text
}
