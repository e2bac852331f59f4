//! `bake verify`: checks a table on its own, and against rays through its mesh.

use crate::cell::Prepared;
use crate::cli::cell::CellArgs;
use crate::cli::failure::Failure;
use crate::cli::report::comparison_text;
use crate::run::{Comparison, RetraceError, Watch, retrace, stated};
use clap::Args;
use std::path::{Path, PathBuf};
use tables::Table;
use tables::cli::{print, warn};

/// Options of `bake verify`.
#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    /// Table to check
    table: PathBuf,
    /// Mesh whose rays are compared with the table
    ///
    /// Rays are traced at some of the table's directions. Eta and the shifts are compared, the exit
    /// directions are not.
    #[arg(long)]
    mesh: Option<PathBuf>,
    #[command(flatten)]
    cell: CellArgs,
    /// Rays per direction, with --mesh
    #[arg(long, value_name = "N", default_value_t = 1_048_576,
        value_parser = clap::value_parser!(u64).range(1..1 << 40))]
    rays: u64,
    /// Seed of the choice of directions and of their rays
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Prints the result as one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs `bake verify`.
pub(crate) fn run(args: &VerifyArgs) -> Result<(), Failure> {
    let table = tables::read(&args.table)?;
    let sealed = tables::is_sealed(&args.table)?;
    let (incidences, azimuths) = table.axes.shape();
    let hash = table.content_hash();
    let comparison = args
        .mesh
        .as_deref()
        .map(|mesh| traced(&table, mesh, args))
        .transpose()?;
    let agrees = comparison.as_ref().map(Comparison::agrees);
    print(&if args.json {
        let value = serde_json::json!({
            "valid": true, "sealed": sealed, "content_hash": hash,
            "directions": incidences * azimuths, "mesh_agrees": agrees });
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
        head + &comparison.map_or(String::new(), |comparison| comparison_text(&comparison))
    })?;
    match (agrees, &args.mesh) {
        (Some(false), Some(mesh)) => Err(Failure::Retraced {
            table: args.table.clone(),
            mesh: mesh.clone(),
        }),
        _ => Ok(()),
    }
}

/// Traces rays through `mesh` and compares them with the table.
///
/// Edge length and azimuth 0 are those of the table, unless the options give others.
///
/// # Errors
/// Returns [`Failure::Unknown`] if a later version made the table with options unknown here,
/// [`Failure::Symmetry`] if the mesh lacks the table's symmetry, and the failures of loading the
/// mesh and of tracing.
fn traced(table: &Table, mesh: &Path, args: &VerifyArgs) -> Result<Comparison, Failure> {
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
    let watch = Watch::none();
    retrace(table, &Prepared::new(cell), args.rays, args.seed, watch).map_err(|error| match error {
        RetraceError::Unknown => unknown(),
        RetraceError::Symmetry => Failure::Symmetry {
            table: args.table.clone(),
            mesh: mesh.to_owned(),
        },
        RetraceError::Run(error) => error.into(),
    })
}
