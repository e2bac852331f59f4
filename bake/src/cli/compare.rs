//! `bake compare`: compares two tables direction by direction.

use crate::cli::report::{comparison_json, comparison_text};
use crate::error::Error;
use crate::run::{Comparison, Difference};
use clap::Args;
use std::path::PathBuf;
use tables::cli::print;

/// Largest difference of eta and of histograms that coordinates of seven digits explain: some 1e-7
/// edge lengths, ten times enlarged by the reflections and by the sides of all polygons.
const FEW_DIGITS: f64 = 1e-6;

/// Options of `bake compare`.
#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// First table
    first: PathBuf,
    /// Second table, of the same directions and bins
    second: PathBuf,
    /// Prints the comparison as one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs `bake compare`.
///
/// # Errors
/// Returns an [`Error`] if the tables differ, after the comparison was printed.
pub(crate) fn run(args: &CompareArgs) -> Result<(), Error> {
    let [a, b] = [tables::read(&args.first)?, tables::read(&args.second)?];
    let comparison = Comparison::new(&a, &b).map_err(|reason| {
        let [first, second] = [&args.first, &args.second].map(|file| file.display());
        Error::Failed(format!(
            "{first} and {second}: {reason}; bake both with the same --incidence, --azimuth, \
            --bins and --range"
        ))
    })?;
    print(&if args.json {
        comparison_json(&comparison)
    } else {
        comparison_text(&comparison)
    })?;
    if comparison.agrees() {
        return Ok(());
    }
    let largest = |of: fn(&Difference) -> f64| comparison.rows.iter().map(of).fold(0.0, f64::max);
    let (eta, l1) = (largest(|row| row.eta.abs()), largest(|row| row.l1));
    let digits = match eta.max(l1) < FEW_DIGITS {
        true => "; so do tables of one cell whose files have few digits, such as 7 in glTF and STL",
        false => "",
    };
    Err(Error::Failed(format!(
        "the tables differ by more than their errors allow: eta by up to {eta:.1e}, the histograms \
        (L1) by up to {l1:.1e}{digits}"
    )))
}
