//! `bake trace`: its options and what is done with them.

use super::{CellArgs, Failure, print, warn};
use crate::exact;
use crate::plan::{Back, Method, Plan, Request, default};
use crate::progress::Progress;
use crate::saves::{self, SavedFile, Saves};
use crate::sequence::Sampler;
use crate::{report, run};
use clap::{Args, ValueEnum};
use meshes::Cell;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use tables::{Outputs, Table};

/// Options of `bake trace`.
#[derive(Debug, Args)]
pub(super) struct TraceArgs {
    /// Mesh: .obj, .gltf or .glb
    mesh: PathBuf,
    /// Table to write (HDF5)
    #[arg(short, long, value_name = "TABLE.h5")]
    output: PathBuf,
    /// Incidence angles outside the sheet, degrees: a list or start:stop:step
    #[arg(long, value_name = "ANGLES", default_value = default::INCIDENCE, allow_hyphen_values = true)]
    incidence: String,
    /// Azimuths, degrees: a list, start:stop:step, or mean for the average over all
    #[arg(long, value_name = "ANGLES", default_value = default::AZIMUTH, allow_hyphen_values = true)]
    azimuth: String,
    /// Refractive index behind a flat front face [default: the file's, else 1]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    refractive_index: Option<f64>,
    /// What the facets are backed with
    #[arg(long, value_enum, default_value_t = Back::Mirror)]
    back: Back,
    /// How to find the distribution
    #[arg(long, value_enum, default_value_t = Method::Auto)]
    method: Method,
    /// How samples are spread
    #[arg(long, value_enum, default_value_t = SamplerName::Sobol)]
    sampler: SamplerName,
    /// Rays per direction [default: 4194304]
    #[arg(long, value_name = "N")]
    rays: Option<u64>,
    /// Trace until the estimated L1 error of every direction is below this
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// Histogram bins along u and along v
    #[arg(long, value_name = "N", default_value_t = default::BINS)]
    bins: usize,
    /// The histogram covers u, v from -RANGE to RANGE, edge lengths
    #[arg(long, default_value_t = default::RANGE, allow_negative_numbers = true)]
    range: f64,
    /// Largest deviation of a path's linear map from -I that counts as retroreflected, degrees
    #[arg(long, value_name = "DEG", default_value_t = default::ANGULAR_TOLERANCE_DEG, allow_negative_numbers = true)]
    angular_tolerance: f64,
    #[command(flatten)]
    cell: CellArgs,
    /// Seed of the samples
    #[arg(long, default_value_t = default::SEED)]
    seed: u64,
    /// Threads [default: all processors]; the table does not depend on it
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Traces only share K of N equal shares of the samples; `bake merge` puts them together
    #[arg(long, value_name = "K/N")]
    shard: Option<String>,
    /// Goes on with the bake of this table that was interrupted, from TABLE.h5.resume beside it
    #[arg(long)]
    resume: bool,
    /// Saves rays that are traced every so many seconds in TABLE.h5.resume, for --resume
    #[arg(long, value_name = "SECONDS", default_value = saves::EVERY_SECONDS, value_parser = seconds)]
    save_every: Duration,
    /// Prints the report as one JSON object
    #[arg(long)]
    json: bool,
}

/// A time from 0 to a year.
fn seconds(text: &str) -> Result<Duration, String> {
    let year = 3e7;
    let number = text.parse::<f64>().ok().filter(|s| (0.0..year).contains(s));
    number
        .map(Duration::from_secs_f64)
        .ok_or_else(|| "give seconds from 0 on".into())
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum SamplerName {
    /// Independent points
    Random,
    /// Owen-scrambled Sobol points
    Sobol,
}

/// Runs `bake trace`.
pub(super) fn run(args: &TraceArgs) -> Result<(), Failure> {
    let plan = Plan::new(&Request {
        incidence: args.incidence.clone(),
        azimuth: args.azimuth.clone(),
        refractive_index: args.refractive_index,
        back: args.back,
        method: args.method,
        sampler: match args.sampler {
            SamplerName::Random => Sampler::Random,
            SamplerName::Sobol => Sampler::Sobol,
        },
        rays: args.rays,
        tolerance: args.tolerance,
        bins: args.bins,
        range: args.range,
        angular_tolerance_deg: args.angular_tolerance,
        seed: args.seed,
        threads: args.threads,
        shard: args.shard.clone(),
    })?;
    let cell = args.cell.load(&args.mesh)?;
    warn(&plan.warnings(&cell));
    warn(&method_warning(args, &cell, &plan));
    let output = Outputs::beside([args.mesh.as_path()]).reserve(&args.output)?;
    let saved = SavedFile::of(output.path());
    let before = saved_before(&saved, args.resume)?;
    let progress = Progress::new(&plan);
    let mut unsaved = None;
    // A disk that is full now may have room at the end: the bake goes on, and says so once.
    let mut save = |table: &Table| unsaved = unsaved.take().or(saved.write(table).err());
    let saves = Saves::new(before, args.save_every, &mut save);
    let start = Instant::now();
    let table = run::bake_from(&cell, &plan, &|rays| progress.advance(rays), Some(saves));
    let seconds = start.elapsed().as_secs_f64();
    progress.finish();
    warn(&Vec::from_iter(unsaved.map(|error| {
        format!("the bake could not be saved on its way: {error}")
    })));
    let table = table?;
    tables::commit(&table, output)?;
    saved.remove();
    let report = report::Trace {
        table: &table,
        file: &args.output,
        seconds,
    };
    print(&if args.json {
        report.json()
    } else {
        report.text()
    })
}

/// What an interrupted bake of the same table has done, if it is to go on.
fn saved_before(saved: &SavedFile, resume: bool) -> Result<Option<Table>, Failure> {
    if resume {
        return Ok(saved.read()?);
    }
    if saved.is_there() {
        warn(&[format!(
            "{} holds an interrupted bake, which --resume would go on with; it is begun anew",
            saved.path().display()
        )]);
    }
    Ok(None)
}

/// What `--method auto` decided, where that is not what the other options suggest; the report names the method anyway.
fn method_warning(args: &TraceArgs, cell: &Cell, plan: &Plan) -> Vec<String> {
    let refusal = exact::prepare(cell, &plan.axes).err();
    let asks_for_rays = args.rays.is_some() || args.tolerance.is_some();
    match (args.method, refusal) {
        (Method::Auto, Some(reason)) => vec![format!("--method auto traces rays: {reason}")],
        (Method::Auto | Method::Exact, None) if asks_for_rays => vec![
            "the exact method traces no rays: --rays and --tolerance have no effect; give --method rays to use them"
                .into(),
        ],
        _ => Vec::new(),
    }
}
