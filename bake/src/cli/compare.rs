//! `bake compare`: compares two tables direction by direction.

use crate::cli::report::{comparison_json, comparison_text};
use crate::error::Error;
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
    match comparison.agrees() {
        true => Ok(()),
        false => Err(Error::Failed(
            "the tables differ by more than their errors allow".into(),
        )),
    }
}
