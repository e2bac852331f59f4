//! `bake merge`: merges tables of one cell.

use crate::error::Error;
use clap::Args;
use std::path::PathBuf;
use tables::cli::{print, warn};
use tables::{Outputs, Table};

/// Options of `bake merge`.
#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// Tables to merge
    #[arg(required = true, value_name = "TABLE.h5")]
    tables: Vec<PathBuf>,
    /// Table to write; it may be one of the merged tables
    #[arg(short, long, value_name = "TABLE.h5")]
    output: PathBuf,
    /// Prints the result as one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs `bake merge`.
pub(crate) fn run(args: &MergeArgs) -> Result<(), Error> {
    // All tables are read before the output is written, so the output may be one of them.
    let output = Outputs::beside([]).reserve_table(&args.output)?;
    let parts = args
        .tables
        .iter()
        .map(|file| tables::read(file))
        .collect::<Result<Vec<Table>, _>>()?;
    let merged = tables::merge(&parts).map_err(|error| {
        let files = args.tables.iter().map(|file| file.display().to_string());
        let files = files.collect::<Vec<_>>().join(", ");
        Error::Failed(format!("{error} (tables, counted from 0: {files})"))
    })?;
    if let Some(shards) = &merged.provenance.shards {
        warn(&[format!(
            "shards {} of {} are missing: the table holds only the rays of the other shards",
            shards.missing_text(),
            shards.of
        )]);
    }
    tables::commit(&merged, output)?;
    let (incidences, azimuths) = merged.axes.shape();
    let (rays, hash) = (merged.rays.sum(), merged.content_hash());
    let shards = merged.provenance.shards.as_ref().map(ToString::to_string);
    Ok(print(&if args.json {
        let value = serde_json::json!({
            "table": args.output.display().to_string(), "merged": parts.len(), "content_hash": hash,
            "directions": incidences * azimuths, "rays": rays, "seed": merged.provenance.seed,
            "shards": shards });
        format!("{value}\n")
    } else {
        format!(
            "{}: {} tables, {} directions, {rays} rays, content {hash}\n",
            args.output.display(),
            parts.len(),
            incidences * azimuths
        )
    })?)
}
