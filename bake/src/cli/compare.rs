//! `bake compare`: two tables, direction by direction.

use crate::cli::failure::Failure;
use crate::cli::report::{comparison_json, comparison_text};
use crate::run::Comparison;
use clap::Args;
use std::path::PathBuf;
use tables::cli::print;

/// Options of `bake compare`.
#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// One table
    first: PathBuf,
    /// Another of the same directions and bins
    second: PathBuf,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs `bake compare`.
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
