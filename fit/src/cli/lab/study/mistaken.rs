//! `fit study --mistakes`: how often a planted mistake is noticed.

use std::fmt::Write;
use std::path::PathBuf;

use tables::Table;

use crate::cli::failure::Failure;
use crate::cli::host::Host;
use crate::cli::lab::study::all::run_all;
use crate::cli::output;
use estimator::estimate::{OtherTable, Verdict};
use lab::study::{Ranges, mistakes, refused};

/// Inputs of a study of planted mistakes.
pub(super) struct Mistaken<'a> {
    pub(super) campaigns: u64,
    pub(super) seed: u64,
    pub(super) other_tables: &'a [PathBuf],
    pub(super) is_json: bool,
    pub(super) ranges: &'a Ranges,
    pub(super) table: &'a Table,
    pub(super) directions: &'a [[f64; 2]],
}

impl Mistaken<'_> {
    /// Runs the study. Returns its text, and one row for each campaign as CSV.
    pub(super) fn run(
        &self,
        pool: &rayon::ThreadPool,
        host: Host<'_>,
    ) -> Result<(String, String), Failure> {
        let mut options = mistakes::options();
        for path in self.other_tables {
            options.others.push(OtherTable::read(path)?);
        }
        let seed = self.seed;
        let (trials, refused) = run_all(self.campaigns, pool, host, |index| {
            let directions = self.of_one_azimuth(index);
            let params = self.ranges.campaign(seed, index, &directions);
            mistakes::run(&params, (seed, index), self.table, &options)
        })?;
        let (rows, bands) = (mistakes::rows(&trials), mistakes::bands(&trials));
        let text = if self.is_json {
            output::json(&serde_json::json!({
                "mistakes": rows,
                "effects": bands,
                "refused": refused,
            }))
        } else {
            caught(&rows, &bands) + &refused::examples(&refused)
        };
        Ok((text, of_mistakes(&trials)))
    }

    /// Returns the directions of one of the azimuths, which take turns.
    fn of_one_azimuth(&self, index: u64) -> Vec<[f64; 2]> {
        let mut azimuths: Vec<f64> = self.directions.iter().map(|d| d[1]).collect();
        azimuths.sort_by(f64::total_cmp);
        azimuths.dedup();
        let own = azimuths[index as usize % azimuths.len()];
        let all = self.directions.iter().copied();
        all.filter(|direction| direction[1] == own).collect()
    }
}

fn caught(rows: &[mistakes::Row], bands: &[mistakes::Band]) -> String {
    let mut text = format!(
        "{:<22}{:>10}{:>8}{:>9}{:>10}{:>8}{:>9}{:>14}\n",
        "mistake", "campaigns", "good", "doubted", "strained", "poor", "refused", "named first"
    );
    for row in rows {
        let good = row.campaigns - row.doubted - row.strained - row.poor - row.refused;
        let _ = writeln!(
            text,
            "{:<22}{:>10}{good:>8}{:>9}{:>10}{:>8}{:>9}{:>14}",
            row.mistake.words(),
            row.campaigns,
            row.doubted,
            row.strained,
            row.poor,
            row.refused,
            row.first
        );
    }
    text.push_str("effect of the mistake, standard errors: caught of campaigns\n");
    for band in bands {
        let _ = writeln!(
            text,
            "  {:>4} to {:<4}{:>6} of {}",
            band.effect[0], band.effect[1], band.caught, band.campaigns
        );
    }
    text
}

fn of_mistakes(trials: &[mistakes::Trial]) -> String {
    let mut text = String::from("campaign,mistake,effect,verdict,named_first,suspects\n");
    for trial in trials {
        let _ = writeln!(
            text,
            "{},{},{},{},{},\"{}\"",
            trial.index,
            trial.mistake.words(),
            trial.effect,
            trial.verdict.map_or("refused", Verdict::name),
            trial.first,
            trial.suspects.join("; ")
        );
    }
    text
}
