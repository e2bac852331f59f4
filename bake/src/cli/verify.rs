//! `bake verify`: checks a table on its own, and against its mesh: by rays, and an exact table by
//! the exact bake made again.

use crate::cell::Prepared;
use crate::cli::cell::CellArgs;
use crate::cli::failure::Failure;
use crate::cli::report::comparison_text;
use crate::run::{Comparison, RetraceError, Watch, consistent, rebake, retrace, stated};
use clap::Args;
use std::path::{Path, PathBuf};
use tables::Table;
use tables::cli::{print, warn, whole};
use tables::reader::Protection;

/// Options of `bake verify`.
#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    /// Table to check
    table: PathBuf,
    /// Mesh that is compared with the table
    ///
    /// Rays are traced at some of the table's directions, and eta, shifts and exit directions are
    /// compared. The exact bake of an exact table is made again in all directions, and compared
    /// path by path, with exit directions and weights.
    #[arg(long)]
    mesh: Option<PathBuf>,
    #[command(flatten)]
    cell: CellArgs,
    /// Rays per direction, with --mesh
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1_048_576,
        value_parser = whole::<u64>(1..1 << 40)
    )]
    rays: u64,
    /// Seed of the choice of directions and of their rays
    #[arg(long, default_value_t = 1, value_parser = whole::<u64>(0..))]
    seed: u64,
    /// Prints the result as one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs `bake verify`.
pub(crate) fn run(args: &VerifyArgs) -> Result<(), Failure> {
    let tables::apart::Reading { table, lacking } = tables::apart::read(&args.table)?;
    consistent(&table).map_err(|source| Failure::Forged {
        file: args.table.clone(),
        source,
    })?;
    let sealed = tables::is_sealed(&args.table)?;
    let (incidences, azimuths) = table.axes.shape();
    let hash = table.content_hash();
    let comparison = args
        .mesh
        .as_deref()
        .map(|mesh| traced(&table, mesh, args))
        .transpose()?;
    let agrees = comparison.as_ref().map(|(rays, _)| rays.agrees());
    let baked = comparison.as_ref().and_then(|(_, baked)| baked.as_ref());
    let polygons = baked.map(Comparison::agrees);
    print(&if args.json {
        let value = serde_json::json!({
            "valid": true, "sealed": sealed, "content_hash": hash,
            "directions": incidences * azimuths, "mesh_agrees": agrees,
            "polygons_agree": polygons,
            "reader_lacks": lacking.iter().map(|one| one.words()).collect::<Vec<_>>() });
        format!("{value}\n")
    } else {
        let seal = if sealed {
            ""
        } else {
            "; its seal is gone because another program wrote to the file, but its content hash is \
            right"
        };
        let head = format!(
            "{}: valid, {} directions, content {hash}{seal}\n",
            args.table.display(),
            incidences * azimuths
        );
        head + &note(&lacking) + &comparison.as_ref().map_or(String::new(), compared)
    })?;
    let (table, mesh) = (args.table.clone(), args.mesh.clone().unwrap_or_default());
    match (agrees, polygons) {
        (Some(false), _) => Err(Failure::Retraced { table, mesh }),
        (_, Some(false)) => Err(Failure::Rebaked { table, mesh }),
        _ => Ok(()),
    }
}

/// Returns the comparison with rays as text, and that with the exact bake if there is one.
fn compared((rays, baked): &(Comparison, Option<Comparison>)) -> String {
    let mut text = comparison_text(rays);
    if let Some(baked) = baked {
        text.push_str("the exact bake made again, path by path:\n");
        text.push_str(&comparison_text(baked));
    }
    text
}

/// Returns what the reader of this table lacked, as a line; nothing if it lacked nothing.
fn note(lacking: &[Protection]) -> String {
    if lacking.is_empty() {
        return String::new();
    }
    let words: Vec<&str> = lacking.iter().map(|one| one.words()).collect();
    format!(
        "note: this system did not give the reader of tables {}; do not open tables of strangers \
        here\n",
        words.join(", ")
    )
}

/// Traces rays through `mesh` and compares them with the table; the exact bake of an exact table
/// too.
///
/// Edge length and azimuth 0 are those of the table, unless the options give others.
///
/// # Errors
/// Returns [`Failure::Unknown`] if a later version made the table with options unknown here,
/// [`Failure::Symmetry`] if the mesh lacks the table's symmetry, and the failures of loading the
/// mesh and of tracing.
fn traced(
    table: &Table,
    mesh: &Path,
    args: &VerifyArgs,
) -> Result<(Comparison, Option<Comparison>), Failure> {
    let from = &table.provenance;
    let unknown = || Failure::Unknown {
        file: args.table.clone(),
        back: from.back.to_string(),
        losses: from.losses.to_string(),
        options: from.options.to_string(),
    };
    // Reading the mesh would be in vain if the other options are not known.
    let scene = stated(from).ok_or_else(unknown)?.scene;
    let cell = CellArgs {
        edge_length: args.cell.edge_length.or(Some(from.edge_length)),
        azimuth_zero: args.cell.azimuth_zero.clone().or_else(|| {
            let [x, y, z] = from.azimuth_zero;
            Some(format!("{x},{y},{z}"))
        }),
        lattice: args.cell.lattice.clone(),
        unit: args.cell.unit.clone(),
    }
    .load(mesh, &scene)?;
    warn(&cell.warnings);
    if cell.mesh_hash != from.mesh_hash {
        warn(&[format!(
            "{} is not the file that the table was baked from (its hash differs); its rays are \
            compared with the table nevertheless",
            mesh.display()
        )]);
    }
    let failed = |error| match error {
        RetraceError::Unknown => unknown(),
        RetraceError::Symmetry => Failure::Symmetry {
            table: args.table.clone(),
            mesh: mesh.to_owned(),
        },
        RetraceError::Run(error) => error.into(),
    };
    let prepared = Prepared::new(cell);
    let rays = retrace(table, &prepared, args.rays, args.seed, Watch::none()).map_err(failed)?;
    let baked = rebake(table, &prepared, Watch::none()).map_err(failed)?;
    Ok((rays, baked))
}
