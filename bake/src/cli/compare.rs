//! `bake compare`: compares two tables direction by direction.

use crate::cli::failure::Failure;
use crate::cli::report::{comparison_json, comparison_text};
use crate::run::Comparison;
use clap::Args;
use std::path::PathBuf;
use tables::cli::print;

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
/// Returns [`Failure::Differ`] if the tables differ, after the comparison was printed.
pub(crate) fn run(args: &CompareArgs) -> Result<(), Failure> {
    let [a, b] = [tables::read(&args.first)?, tables::read(&args.second)?];
    let comparison = Comparison::new(&a, &b).map_err(|reason| Failure::Axes {
        first: args.first.clone(),
        second: args.second.clone(),
        reason,
    })?;
    print(&if args.json {
        comparison_json(&comparison)
    } else {
        comparison_text(&comparison)
    })?;
    if comparison.agrees() {
        Ok(())
    } else {
        Err(Failure::Differ)
    }
}
