//! `bake trace`: its options and what is done with them.

use super::{CellArgs, Failure, print, warn};
use crate::exact::ExactCell;
use crate::plan::{Back, Method, Plan, Request, default};
use crate::progress::Progress;
use crate::provenance::provenance;
use crate::ranks::{Launched, Ranks};
use crate::saves::{self, SavedFile, Saves};
use crate::sequence::Sampler;
use crate::{report, run};
use clap::{Args, ValueEnum};
use meshes::Cell;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::PathBuf;
use std::time::{Duration, Instant};
use tables::{Output, Outputs, Table};

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
    /// Azimuths, degrees: a list, start:stop:step, full for all (steps of 5, full:STEP for others; of a symmetric cell only a
    /// sector is baked), or mean for the average over all
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

impl TraceArgs {
    fn request(&self) -> Request {
        Request {
            incidence: self.incidence.clone(),
            azimuth: self.azimuth.clone(),
            refractive_index: self.refractive_index,
            back: self.back,
            method: self.method,
            sampler: match self.sampler {
                SamplerName::Random => Sampler::Random,
                SamplerName::Sobol => Sampler::Sobol,
            },
            rays: self.rays,
            tolerance: self.tolerance,
            bins: self.bins,
            range: self.range,
            angular_tolerance_deg: self.angular_tolerance,
            seed: self.seed,
            threads: self.threads,
            shard: self.shard.clone(),
        }
    }
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

/// Runs `bake trace` as one of `ranks`; `launched` is what started them.
pub(super) fn run(
    args: &TraceArgs,
    ranks: &dyn Ranks,
    launched: Option<Launched>,
) -> Result<(), Failure> {
    if let Some(Launched { number, count }) = launched
        && (ranks.count() == 1 && count > 1 && args.shard.is_none())
    {
        return Err(match number {
            0 => Failure::NotJoined { count },
            _ => Failure::Elsewhere,
        });
    }
    let Ready {
        plan,
        cell,
        output,
        before,
    } = agreed(Ready::new(args, ranks.leads()), ranks)?;
    agreed(same_everywhere(&plan, &cell, ranks), ranks)?;
    let progress = Progress::new(&plan, ranks.leads());
    let saved = SavedFile::of(&args.output);
    let mut unsaved = None;
    // A disk that is full now may have room at the end: the bake goes on, and says so once.
    let mut save = |table: &Table| unsaved = unsaved.take().or(saved.write(table).err());
    let saves = Saves::new(before, args.save_every, &mut save);
    let start = Instant::now();
    let advance = |rays| progress.advance(rays);
    let table = run::bake_from(&cell, &plan, &advance, Some(saves), ranks);
    let seconds = start.elapsed().as_secs_f64();
    progress.finish();
    warn(&Vec::from_iter(unsaved.map(|error| {
        format!("the bake could not be saved on its way: {error}")
    })));
    let table = match table.map_err(Failure::from) {
        // The others wait for what this rank no longer does.
        Err(failure) if ranks.count() > 1 => {
            failure.print();
            ranks.abort(failure.code());
        }
        table => table?,
    };
    let (Some(table), Some(output)) = (table, output) else {
        return Ok(());
    };
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

/// A bake whose options, mesh and output are in order.
struct Ready {
    plan: Plan,
    cell: Cell,
    /// Reserved by who writes.
    output: Option<Output>,
    before: Option<Table>,
}

impl Ready {
    /// `leads`: this process prints, writes and reads what was saved.
    fn new(args: &TraceArgs, leads: bool) -> Result<Self, Failure> {
        let plan = Plan::new(&args.request())?;
        let cell = args.cell.load(&args.mesh)?;
        let plan = plan.fold(&cell);
        let mut ready = Ready {
            plan,
            cell,
            output: None,
            before: None,
        };
        if leads {
            warn(&ready.cell.warnings);
            warn(&ready.plan.warnings(&ready.cell));
            warn(&method_warning(args, &ready.cell));
            let output = Outputs::beside([args.mesh.as_path()]).reserve(&args.output)?;
            ready.before = saved_before(&SavedFile::of(output.path()), args.resume)?;
            ready.output = Some(output);
        }
        Ok(ready)
    }
}

/// What this rank has got ready, if all have; the failure of the first that has not is for that rank to tell.
fn agreed<T>(ready: Result<T, Failure>, ranks: &dyn Ranks) -> Result<T, Failure> {
    match ranks.first_of(ready.is_err()) {
        Some(first) if first != ranks.number() => Err(Failure::Elsewhere),
        _ => ready,
    }
}

/// Whether this rank bakes what rank 0 bakes: machines may hold another mesh under the same name, or another program.
fn same_everywhere(plan: &Plan, cell: &Cell, ranks: &dyn Ranks) -> Result<(), Failure> {
    let plan = Plan {
        threads: None,
        ..plan.clone()
    };
    let provenance = provenance(cell, &plan, String::new(), String::new());
    let mut hasher = DefaultHasher::new();
    format!("{plan:?} {provenance:?}").hash(&mut hasher);
    let mut first = [hasher.finish()];
    ranks.follow(&mut first);
    if first == [hasher.finish()] {
        Ok(())
    } else {
        let rank = ranks.number();
        Err(Failure::OtherBake { rank })
    }
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
fn method_warning(args: &TraceArgs, cell: &Cell) -> Vec<String> {
    let refusal = ExactCell::new(cell).err();
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
