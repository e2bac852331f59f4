//! `bake trace`: reads its options, bakes one table for each wavelength, and reports.

use crate::cell::Prepared;
use crate::cli::cell::CellArgs;
use crate::cli::failure::Failure;
use crate::cli::heading;
use crate::cli::host::Caller;
use crate::cli::progress::{self, Progress};
use crate::cli::report;
use crate::optics::material;
use crate::plan::{BINS_LIMIT, MOST_THREADS, Plan, PlanError, Request, default};
use crate::run::{Bake, Launched, Ranks, SavedFile, Saves, Watch, saves};
use clap::Args;
use meshes::Mesh;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tables::cli::{number, print, warn, whole};
use tables::options::{Back, Losses, Method, Record, Sampler, SceneOptions};
use tables::{Output, Outputs, Table};

/// Options of `bake trace`.
#[derive(Debug, Args)]
#[command(mut_arg("deviations", |arg| arg.help_heading(heading::ACCURACY)))]
pub(crate) struct TraceArgs {
    /// Mesh file of one cell: .obj, .gltf, .glb, .stl or .ply
    mesh: PathBuf,
    /// Table to write, an HDF5 file
    ///
    /// With several wavelengths, write {nm} in the name where the wavelength belongs.
    #[arg(short, long, value_name = "TABLE.h5")]
    output: PathBuf,
    /// Refractive index behind the front face [default: the file's, else 1]
    ///
    /// A number from 1 to 10; a material: pmma (acrylic), polycarbonate or bk7; or pairs nm:index
    /// such as 450:1.50,650:1.49. A material and pairs need --wavelength-nm.
    #[arg(long, value_name = "M", allow_hyphen_values = true)]
    refractive_index: Option<String>,
    /// Angles of incidence in the air, degrees
    ///
    /// A list such as 0,15,30, or start:stop:step. The angle is measured from the sheet's normal.
    #[arg(
        long,
        value_name = "ANGLES",
        default_value = default::INCIDENCE,
        allow_hyphen_values = true
    )]
    incidence: String,
    /// Azimuths about the sheet's normal, degrees
    ///
    /// A list such as 0,30; start:stop:step; full for all azimuths in steps of at most 5 degrees,
    /// or full:STEP for another step; or mean for the average over all azimuths. With full, only
    /// one sector of a symmetric cell is baked. It stands for all azimuths.
    #[arg(
        long,
        value_name = "ANGLES",
        default_value = default::AZIMUTH,
        allow_hyphen_values = true
    )]
    azimuth: String,
    /// Histogram bins along u and along v
    #[arg(
        long,
        value_name = "N",
        default_value_t = default::BINS,
        help_heading = heading::ACCURACY,
        value_parser = whole::<usize>(1..=BINS_LIMIT)
    )]
    bins: usize,
    /// Half width of the histogram, edge lengths
    ///
    /// The histogram covers shifts u and v from -RANGE to RANGE.
    #[arg(
        long,
        value_parser = number,
        default_value_t = default::RANGE,
        allow_negative_numbers = true,
        help_heading = heading::ACCURACY
    )]
    range: f64,
    /// Largest deviation of retroreflected light, degrees
    ///
    /// A path counts as retroreflected if its linear map deviates from -I by at most this angle.
    /// For a plate, the map of its image takes the place of -I. With --glass-index, the exit
    /// direction decides.
    #[arg(
        long,
        value_parser = number,
        value_name = "DEG",
        default_value_t = default::ANGULAR_TOLERANCE_DEG,
        allow_negative_numbers = true,
        help_heading = heading::ACCURACY
    )]
    angular_tolerance: f64,
    /// Chooses directions that keep the interpolation error below TV
    ///
    /// Chooses the fewest directions between the ends of --incidence and of --azimuth, so that the
    /// polygons of an exact table, interpolated, give every other direction within this total
    /// variation of eta x histogram (above 0, at most 1). Steps, and listed angles between the
    /// ends, have no effect.
    #[arg(
        long,
        value_parser = number,
        value_name = "TV",
        allow_negative_numbers = true,
        help_heading = heading::ACCURACY
    )]
    direction_tolerance: Option<f64>,
    /// Wavelengths in vacuum, nm
    ///
    /// Each wavelength has a table of its own.
    #[arg(
        long,
        alias = "wavelengths-nm",
        value_name = "NM,..",
        value_delimiter = ',',
        allow_negative_numbers = true,
        help_heading = heading::MATERIAL
    )]
    wavelength_nm: Vec<f64>,
    /// Backing of facets
    #[arg(long, value_enum, default_value_t = Back::Mirror, help_heading = heading::MATERIAL)]
    back: Back,
    /// Losses at surfaces
    ///
    /// With none, the reflectance mu that fit estimates contains these losses.
    #[arg(long, value_enum, default_value_t = Losses::None, help_heading = heading::MATERIAL)]
    losses: Losses,
    /// Metal of the mirrors: aluminium, silver or N,K
    ///
    /// N,K is the complex refractive index, such as 0.96,6.7. A name needs --wavelength-nm. Needs
    /// --losses fresnel and excludes --reflectance.
    #[arg(long, value_name = "NAME", allow_hyphen_values = true, help_heading = heading::MATERIAL)]
    metal: Option<String>,
    /// Share of the light that a mirror facet reflects [default: 1]
    ///
    /// Needs --losses fresnel.
    #[arg(
        long,
        value_parser = number,
        value_name = "R",
        allow_negative_numbers = true,
        help_heading = heading::MATERIAL
    )]
    reflectance: Option<f64>,
    #[command(flatten, next_help_heading = heading::MATERIAL)]
    scene: SceneOptions,
    #[command(flatten, next_help_heading = heading::CELL)]
    cell: CellArgs,
    /// Exact beams or rays
    #[arg(long, value_enum, default_value_t = Method::Auto, help_heading = heading::RAYS)]
    method: Method,
    /// Rays per direction [default: 4194304]
    #[arg(long, value_name = "N", help_heading = heading::RAYS, value_parser = whole::<u64>(1..))]
    rays: Option<u64>,
    /// Traces until the estimated L1 error of every direction is below E
    ///
    /// The L1 error is the sum, over the bins of eta x histogram, of the absolute errors. It is at
    /// most 2. Not together with --rays, --shard or --sampler random.
    #[arg(
        long,
        value_parser = number,
        value_name = "E",
        allow_negative_numbers = true,
        help_heading = heading::RAYS
    )]
    tolerance: Option<f64>,
    /// Kind of sample points
    #[arg(long, value_enum, default_value_t = Sampler::Sobol, help_heading = heading::RAYS)]
    sampler: Sampler,
    /// Seed of the samples
    ///
    /// To add rays to a table, bake again with the seed that follows, and merge the two tables.
    #[arg(
        long,
        default_value_t = default::SEED,
        help_heading = heading::RAYS,
        value_parser = whole::<u64>(0..)
    )]
    seed: u64,
    /// Traces only share K of N equal shares of the samples
    ///
    /// Merge the N tables with bake merge. The result is the table of a single bake, byte for byte.
    #[arg(long, value_name = "K/N", help_heading = heading::LONG_RUNS)]
    shard: Option<String>,
    /// Continues the interrupted bake of this table
    ///
    /// Reads TABLE.h5.resume beside the table. Give all other options again.
    #[arg(long, help_heading = heading::LONG_RUNS)]
    resume: bool,
    /// Seconds between two saves of the rays traced so far
    ///
    /// They are saved in TABLE.h5.resume, for --resume.
    #[arg(
        long,
        value_name = "SECONDS",
        default_value = saves::EVERY_SECONDS,
        value_parser = seconds,
        help_heading = heading::LONG_RUNS
    )]
    save_every: Duration,
    /// Prints the report as one JSON object
    #[arg(long, help_heading = heading::OUTPUT)]
    json: bool,
    /// Number of threads [default: all processors]
    ///
    /// The table does not depend on it.
    #[arg(
        long,
        value_name = "N",
        help_heading = heading::OUTPUT,
        value_parser = whole::<usize>(1..=MOST_THREADS)
    )]
    threads: Option<usize>,
}

impl TraceArgs {
    /// Returns what is asked of the table of one wavelength (nm), or of the only table.
    fn request(&self, wavelength_nm: Option<f64>) -> Result<Request, PlanError> {
        let index = self.refractive_index.as_deref();
        let index = index.map(|text| material::refractive_index(text, wavelength_nm));
        let metal = self.metal.as_deref();
        let metal = metal.map(|text| material::metal(text, wavelength_nm));
        Ok(Request {
            incidence: self.incidence.clone(),
            azimuth: self.azimuth.clone(),
            refractive_index: index.transpose()?,
            back: self.back,
            losses: self.losses,
            reflectance: self.reflectance,
            metal: metal.transpose()?,
            wavelength_nm,
            method: self.method,
            sampler: self.sampler,
            rays: self.rays,
            tolerance: self.tolerance,
            bins: self.bins,
            range: self.range,
            angular_tolerance_deg: self.angular_tolerance,
            seed: self.seed,
            threads: self.threads,
            shard: self.shard.clone(),
            direction_tolerance: self.direction_tolerance,
            scene: self.scene,
        })
    }

    /// Returns the tables to write, each with its wavelength in nm if one is named.
    fn tables(&self) -> Result<Vec<(PathBuf, Option<f64>)>, PlanError> {
        let name = self.output.to_string_lossy();
        let named = name.contains("{nm}");
        match &self.wavelength_nm[..] {
            [] if named => Err(PlanError::NoWavelength {
                output: name.into_owned(),
            }),
            [] => Ok(vec![(self.output.clone(), None)]),
            [_, _, ..] if !named => Err(PlanError::OneFile {
                wavelengths: self.wavelength_nm.len(),
                output: name.into_owned(),
            }),
            wavelengths
                if (1..wavelengths.len()).any(|k| wavelengths[..k].contains(&wavelengths[k])) =>
            {
                Err(PlanError::Twice {
                    wavelengths: wavelengths.to_vec(),
                })
            }
            wavelengths => Ok(wavelengths
                .iter()
                .map(|nm| match named {
                    true => (name.replace("{nm}", &nm.to_string()).into(), Some(*nm)),
                    false => (self.output.clone(), Some(*nm)),
                })
                .collect()),
        }
    }
}

/// Reads a time in seconds, from 0 to about a year.
fn seconds(text: &str) -> Result<Duration, String> {
    let year = 3e7;
    let number = text.parse::<f64>().ok().filter(|s| (0.0..year).contains(s));
    number
        .map(Duration::from_secs_f64)
        .ok_or_else(|| "give a number of seconds from 0 to below 3e7 (a year)".into())
}

/// Runs `bake trace` as one of `ranks`; `launched` is what started them.
pub(crate) fn run(
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
    let (prepared, plans) = agreed(inputs(args), ranks)?;
    let jobs = agreed(jobs(args, &prepared, &plans, ranks.leads()), ranks)?;
    for job in &jobs {
        agreed(same_everywhere(&job.bake, ranks), ranks)?;
    }
    let mut said = Vec::new();
    for job in jobs {
        said.extend(job.run(args, ranks)?);
    }
    match &said[..] {
        [] => Ok(()),
        [one] if args.json => Ok(print(&format!("{one}\n"))?),
        all if args.json => Ok(print(&format!(
            "{}\n",
            serde_json::json!({ "tables": all })
        ))?),
        _ => Ok(()),
    }
}

/// File of a table to write, and the plan that makes it.
type Planned = (PathBuf, Plan);

/// Reads the mesh, and returns the dissected cell and one plan for each table.
fn inputs(args: &TraceArgs) -> Result<(Prepared, Vec<Planned>), Failure> {
    let plans = args
        .tables()?
        .into_iter()
        .map(|(file, nm)| Ok((file, Plan::new(&args.request(nm)?)?)))
        .collect::<Result<Vec<_>, PlanError>>()?;
    let cell = args.cell.load(&args.mesh, &args.scene)?;
    Ok((Prepared::new(cell), plans))
}

/// Bakes the one table of `args` for another program; a `mesh` in memory takes the place of the
/// file. Nothing is printed or written.
///
/// Returns the table and the warnings.
///
/// # Errors
/// Fails as [`run`] does, and if the caller stopped the bake.
pub(super) fn called(
    args: &TraceArgs,
    mesh: Option<&Mesh>,
    caller: &Caller,
) -> Result<(Table, Vec<String>), Failure> {
    let wavelength_nm = args.tables()?.first().and_then(|(_, nm)| *nm);
    let plan = Plan::new(&args.request(wavelength_nm)?)?;
    let cell = match mesh {
        Some(mesh) => args.cell.of_mesh(mesh, &args.mesh, &args.scene)?,
        None => args.cell.load(&args.mesh, &args.scene)?,
    };
    let prepared = Prepared::new(cell);
    let mut warnings = prepared.cell().warnings.clone();
    warnings.extend(plan.warnings(&prepared));
    warnings.extend(method_warning(args, &prepared, &plan));
    let stopped = Watch::none().stopped_by(caller.stop);
    let bake = Bake::watched(&prepared, &plan, stopped)?;
    let (all, done) = (progress::rays(&bake), AtomicU64::new(0));
    let told = |rays| (caller.told)(rays + done.fetch_add(rays, Ordering::Relaxed), all);
    let table = bake.table(Watch::new(&told).stopped_by(caller.stop))?;
    let report = report::Trace {
        table: &table,
        file: &args.output,
        seconds: 0.0,
        between: None,
    };
    warnings.extend(report.warnings());
    Ok((table, warnings))
}

/// Table to be made: a bake whose options, mesh and output have been checked.
struct Job<'a> {
    bake: Bake<'a>,
    file: &'a Path,
    /// Place of the table on the disk; `None` in a process that does not write.
    output: Option<Output>,
    /// Rays of an interrupted bake, with which this one begins.
    before: Option<Table>,
}

/// Prints warnings, reserves the outputs and returns one job for each plan.
///
/// Only the process that `leads` prints, writes, and reads what an interrupted bake saved.
fn jobs<'a>(
    args: &TraceArgs,
    prepared: &'a Prepared,
    plans: &'a [Planned],
    leads: bool,
) -> Result<Vec<Job<'a>>, Failure> {
    let mut outputs = Outputs::beside([args.mesh.as_path()]);
    if leads {
        warn(&prepared.cell().warnings);
        let mut warnings: Vec<String> = plans
            .iter()
            .flat_map(|(_, plan)| plan.warnings(prepared))
            .collect();
        warnings.dedup();
        warn(&warnings);
        warn(method_warning(args, prepared, &plans[0].1));
    }
    let mut jobs = Vec::new();
    for (file, plan) in plans {
        let (mut output, mut before) = (None, None);
        if leads {
            let reserved = outputs.reserve_table(file)?;
            before = saved_before(&SavedFile::of(reserved.path()), args.resume)?;
            output = Some(reserved);
        }
        jobs.push(Job {
            bake: Bake::new(prepared, plan)?,
            file,
            output,
            before,
        });
    }
    Ok(jobs)
}

impl Job<'_> {
    /// Bakes and writes the table, prints its report unless `--json` was given, and returns the
    /// report as JSON.
    ///
    /// Returns `None` in a rank that does not write.
    fn run(
        self,
        args: &TraceArgs,
        ranks: &dyn Ranks,
    ) -> Result<Option<serde_json::Value>, Failure> {
        let progress = Progress::new(&self.bake, ranks.leads());
        // A table that is written through a link is saved where the link leads, as it is read.
        let reserved = self.output.as_ref().map(Output::path);
        let saved = SavedFile::of(reserved.unwrap_or(self.file));
        let mut unsaved = None;
        // A disk that is full now may have room at the end. So the bake continues if a save fails,
        // and the failure is printed once.
        let mut save = |table: &Table| unsaved = unsaved.take().or(saved.write(table).err());
        let saves = Saves::new(self.before, args.save_every, &mut save);
        let start = Instant::now();
        let advance = |rays| progress.advance(rays);
        let table = self
            .bake
            .table_from(Watch::new(&advance), Some(saves), ranks);
        let seconds = start.elapsed().as_secs_f64();
        progress.finish();
        warn(Vec::from_iter(unsaved.map(|error| {
            format!("the bake could not be saved for --resume: {error}")
        })));
        let table = match table.map_err(Failure::from) {
            // The other ranks wait for this one, so all of them are stopped.
            Err(failure) if ranks.count() > 1 => {
                failure.print();
                ranks.abort(failure.code());
                return Err(Failure::Elsewhere);
            }
            table => table?,
        };
        let (Some(table), Some(output)) = (table, self.output) else {
            return Ok(None);
        };
        tables::commit(&table, output)?;
        saved.remove();
        let report = report::Trace {
            table: &table,
            file: self.file,
            seconds,
            between: self.bake.between(&table),
        };
        warn(report.warnings());
        if !args.json {
            print(&report.text())?;
        }
        Ok(Some(report.json()))
    }
}

/// Returns what this rank has prepared, if all ranks have succeeded.
///
/// # Errors
/// Returns the rank's own failure in the lowest rank that failed, and [`Failure::Elsewhere`] in all
/// others, so that the failure is printed once.
fn agreed<T>(ready: Result<T, Failure>, ranks: &dyn Ranks) -> Result<T, Failure> {
    match ranks.first_of(ready.is_err()) {
        Some(first) if first != ranks.number() => Err(Failure::Elsewhere),
        _ => ready,
    }
}

/// Checks that this rank bakes what rank 0 bakes.
///
/// A machine may hold another mesh under the same name, or another version of the program.
///
/// # Errors
/// Returns [`Failure::OtherBake`] if version, plan, axes or provenance differ from those of rank 0.
fn same_everywhere(bake: &Bake, ranks: &dyn Ranks) -> Result<(), Failure> {
    let plan = Plan {
        threads: None,
        ..bake.plan.clone()
    };
    let (axes, provenance) = (bake.axes(), bake.provenance(plan.method, None));
    let mut hasher = DefaultHasher::new();
    format!(
        "{} {plan:?} {axes:?} {provenance:?}",
        env!("CARGO_PKG_VERSION")
    )
    .hash(&mut hasher);
    let mut first = [hasher.finish()];
    ranks.follow(&mut first);
    if first == [hasher.finish()] {
        Ok(())
    } else {
        let rank = ranks.number();
        Err(Failure::OtherBake { rank })
    }
}

/// Reads what an interrupted bake of the same table has saved, if `resume` asks for it.
///
/// Without `resume`, warns that a saved bake is there and returns `None`.
fn saved_before(saved: &SavedFile, resume: bool) -> Result<Option<Table>, Failure> {
    if resume {
        return Ok(saved.read()?);
    }
    if saved.is_there()? {
        warn(&[format!(
            "{} holds an interrupted bake, which --resume would go on with; this bake starts from \
            the beginning",
            saved.path().display()
        )]);
    }
    Ok(None)
}

/// Returns a warning if the method that was chosen ignores other options, or is not the exact one.
///
/// The report names the method in any case.
fn method_warning(args: &TraceArgs, prepared: &Prepared, plan: &Plan) -> Vec<String> {
    let refusal = plan.exact_cell(prepared).err();
    let asks_for_rays = args.rays.is_some() || args.tolerance.is_some();
    match (args.method, refusal) {
        (Method::Auto, Some(reason)) => vec![format!("--method auto traces rays: {reason}")],
        (Method::Auto | Method::Exact, None)
            if plan.scene.deviations != Record::Auto && !plan.is_azimuth_mean() =>
        {
            vec![
                "the exact method records where each path goes, so --deviations has no effect; \
                give --method rays to use it"
                    .into(),
            ]
        }
        (Method::Auto | Method::Exact, None) if asks_for_rays => vec![
            "the exact method traces no rays: --rays and --tolerance have no effect; give \
            --method rays to use them"
                .into(),
        ],
        _ => Vec::new(),
    }
}
