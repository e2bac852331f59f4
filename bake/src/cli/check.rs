//! `bake verify` and `bake merge`: what is done with tables that are there.

use crate::cell::symmetry;
use crate::cli::cli::{CellArgs, Failure, print, warn};
use crate::cli::report;
use crate::run::provenance::losses_of;
use crate::run::retrace::retrace;
use clap::Args;
use std::path::{Path, PathBuf};
use tables::{Outputs, Symmetry, Table};

/// Options of `bake verify`.
#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    /// Table to check
    table: PathBuf,
    /// Traces rays through this mesh at some of the table's directions, and compares eta and shifts (exit directions are not
    /// compared)
    #[arg(long)]
    mesh: Option<PathBuf>,
    #[command(flatten)]
    cell: CellArgs,
    /// Rays per direction of that trace
    #[arg(long, value_name = "N", default_value_t = 1_048_576,
        value_parser = clap::value_parser!(u64).range(1..1 << 40))]
    rays: u64,
    /// Seed that chooses the directions and their rays
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
}

/// Options of `bake merge`.
#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// Tables to put together
    #[arg(required = true, value_name = "TABLE.h5")]
    tables: Vec<PathBuf>,
    /// Table to write; it may be one of those that are read
    #[arg(short, long, value_name = "TABLE.h5")]
    output: PathBuf,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs `bake verify`.
pub(crate) fn verify(args: &VerifyArgs) -> Result<(), Failure> {
    let table = tables::read(&args.table)?;
    let sealed = tables::is_sealed(&args.table)?;
    let (incidences, azimuths) = table.axes.shape();
    let hash = table.content_hash();
    let comparison = args
        .mesh
        .as_deref()
        .map(|mesh| traced(&table, mesh, args))
        .transpose()?;
    let agrees = comparison.as_ref().map(report::Comparison::agrees);
    print(&if args.json {
        let value = serde_json::json!({
            "valid": true, "sealed": sealed, "content_hash": hash, "directions": incidences * azimuths,
            "mesh_agrees": agrees });
        format!("{value}\n")
    } else {
        let seal = if sealed {
            ""
        } else {
            "; its seal is gone: another program wrote to it, its content hash still holds"
        };
        let head = format!(
            "{}: valid, {} directions, content {hash}{seal}\n",
            args.table.display(),
            incidences * azimuths
        );
        head + &comparison.map_or(String::new(), |comparison| comparison.text())
    })?;
    match (agrees, &args.mesh) {
        (Some(false), Some(mesh)) => Err(Failure::Retraced {
            table: args.table.clone(),
            mesh: mesh.clone(),
        }),
        _ => Ok(()),
    }
}

/// The comparison with rays through `mesh`, placed as the table says unless the options say otherwise.
fn traced(table: &Table, mesh: &Path, args: &VerifyArgs) -> Result<report::Comparison, Failure> {
    let from = &table.provenance;
    let known = (from.back.known(), losses_of(from), from.options.known());
    let (Some(back), Ok(losses), Some(scene)) = known else {
        return Err(Failure::Unknown {
            file: args.table.clone(),
            back: from.back.to_string(),
            losses: from.losses.to_string(),
            options: from.options.to_string(),
        });
    };
    let cell = CellArgs {
        edge_length: args.cell.edge_length.or(Some(from.edge_length)),
        azimuth_zero: args.cell.azimuth_zero.clone().or_else(|| {
            let [x, y, z] = from.azimuth_zero;
            Some(format!("{x},{y},{z}"))
        }),
        lattice: args.cell.lattice.clone(),
    }
    .load(mesh, &scene)?;
    warn(&cell.warnings);
    if cell.mesh_hash != from.mesh_hash {
        warn(&[format!(
            "{} is not the file that the table was baked from (its hash differs); the rays judge it all the same",
            mesh.display()
        )]);
    }
    if from.symmetry != Symmetry::NONE && from.symmetry != symmetry::of(&cell) {
        return Err(Failure::Symmetry {
            table: args.table.clone(),
            mesh: mesh.to_owned(),
        });
    }
    Ok(retrace(
        table, back, losses, scene, &cell, args.rays, args.seed,
    )?)
}

/// Runs `bake merge`.
pub(crate) fn merge(args: &MergeArgs) -> Result<(), Failure> {
    // All are read before the output is written, so that rays can be added in place.
    let output = Outputs::beside([]).reserve(&args.output)?;
    let parts = args
        .tables
        .iter()
        .map(|file| tables::read(file))
        .collect::<Result<Vec<Table>, _>>()?;
    let merged = tables::merge(&parts).map_err(|source| Failure::Merge {
        files: args.tables.clone(),
        source: Box::new(source),
    })?;
    if let Some(shards) = &merged.provenance.shards {
        warn(&[format!(
            "shards {} of {} are missing: the table holds the rays of the others",
            shards.missing_text(),
            shards.of
        )]);
    }
    tables::commit(&merged, output)?;
    let (incidences, azimuths) = merged.axes.shape();
    let (rays, hash) = (merged.rays.sum(), merged.content_hash());
    let shards = merged.provenance.shards.as_ref().map(ToString::to_string);
    print(&if args.json {
        let value = serde_json::json!({
            "table": args.output.display().to_string(), "merged": parts.len(), "content_hash": hash,
            "directions": incidences * azimuths, "rays": rays, "seed": merged.provenance.seed, "shards": shards });
        format!("{value}\n")
    } else {
        format!(
            "{}: {} tables, {} directions, {rays} rays, content {hash}\n",
            args.output.display(),
            parts.len(),
            incidences * azimuths
        )
    })
}
