//! `bake trace`: its options and what is done with them.

use crate::cell::Prepared;
use crate::cli::cell::CellArgs;
use crate::cli::failure::Failure;
use crate::cli::progress::Progress;
use crate::cli::report;
use crate::optics::material;
use crate::plan::{Plan, PlanError, Request, default};
use crate::run::{Bake, Launched, Ranks, SavedFile, Saves, Watch, saves};
use clap::Args;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tables::cli::{print, warn};
use tables::options::{Back, Losses, Method, Record, Sampler, SceneOptions};
use tables::{Output, Outputs, Table};

/// Options of `bake trace`.
#[derive(Debug, Args)]
pub(crate) struct TraceArgs {
    /// Mesh: .obj, .gltf or .glb
    mesh: PathBuf,
    /// Table to write (HDF5); {nm} in the name stands for the wavelength
    #[arg(short, long, value_name = "TABLE.h5")]
    output: PathBuf,
    /// Incidence angles outside the sheet, degrees: a list or start:stop:step
    #[arg(long, value_name = "ANGLES", default_value = default::INCIDENCE, allow_hyphen_values = true)]
    incidence: String,
    /// Azimuths, degrees: a list, start:stop:step, full for all (steps of 5, full:STEP for others;
    /// of a symmetric cell only a sector is baked), or mean for the average over all
    #[arg(long, value_name = "ANGLES", default_value = default::AZIMUTH, allow_hyphen_values = true)]
    azimuth: String,
    /// Chooses the directions between the ends of --incidence and of --azimuth (steps and what else
    /// is listed are left aside), so that the polygons of an exact table give every other one
    /// within this total variation of eta x histogram
    #[arg(long, value_name = "TV", allow_negative_numbers = true)]
    direction_tolerance: Option<f64>,
    /// Refractive index behind a flat front face: a number, pmma, polycarbonate, bk7, or pairs
    /// nm:index [default: the file's, else 1]
    #[arg(long, value_name = "M", allow_hyphen_values = true)]
    refractive_index: Option<String>,
    /// Wavelengths in vacuum, nm: each has a table of its own
    #[arg(
        long,
        alias = "wavelengths-nm",
        value_name = "NM,..",
        value_delimiter = ',',
        allow_negative_numbers = true
    )]
    wavelength_nm: Vec<f64>,
    /// What the facets are backed with
    #[arg(long, value_enum, default_value_t = Back::Mirror)]
    back: Back,
    /// What surfaces take from the light
    #[arg(long, value_enum, default_value_t = Losses::None)]
    losses: Losses,
    /// Part of the light that each mirror facet reflects, with --losses fresnel [default: 1]
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    reflectance: Option<f64>,
    /// Metal of the mirrors, with --losses fresnel: aluminium, silver, or the complex index N,K
    #[arg(long, value_name = "NAME", allow_hyphen_values = true)]
    metal: Option<String>,
    /// How to find the distribution
    #[arg(long, value_enum, default_value_t = Method::Auto)]
    method: Method,
    /// How samples are spread
    #[arg(long, value_enum, default_value_t = Sampler::Sobol)]
    sampler: Sampler,
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
    scene: SceneOptions,
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
    /// What is asked of the table of one wavelength, where any is named.
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

    /// The tables to write and their wavelengths.
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

/// A time from 0 to a year.
fn seconds(text: &str) -> Result<Duration, String> {
    let year = 3e7;
    let number = text.parse::<f64>().ok().filter(|s| (0.0..year).contains(s));
    number
        .map(Duration::from_secs_f64)
        .ok_or_else(|| "give seconds from 0 on".into())
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

/// A plan and the table that it makes.
type Planned = (PathBuf, Plan);

/// The cell, dissected, and the plans, one for each table.
fn inputs(args: &TraceArgs) -> Result<(Prepared, Vec<Planned>), Failure> {
    let plans = args
        .tables()?
        .into_iter()
        .map(|(file, nm)| Ok((file, Plan::new(&args.request(nm)?)?)))
        .collect::<Result<Vec<_>, PlanError>>()?;
    let cell = args.cell.load(&args.mesh, &args.scene)?;
    Ok((Prepared::new(cell), plans))
}

/// One table to be: a bake whose options, mesh and output are in order.
struct Job<'a> {
    bake: Bake<'a>,
    file: &'a Path,
    /// Reserved by who writes.
    output: Option<Output>,
    before: Option<Table>,
}

/// Says what the user should know and reserves the outputs; `leads`: this process prints, writes
/// and reads what was saved.
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
            let reserved = outputs.reserve(file)?;
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
    /// Bakes and writes the table and says what is in it: at once for a person, as an object for a
    /// script. Nothing in the ranks that do not write.
    fn run(
        self,
        args: &TraceArgs,
        ranks: &dyn Ranks,
    ) -> Result<Option<serde_json::Value>, Failure> {
        let progress = Progress::new(&self.bake, ranks.leads());
        let saved = SavedFile::of(self.file);
        let mut unsaved = None;
        // A disk that is full now may have room at the end: the bake goes on, and says so once.
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
            format!("the bake could not be saved on its way: {error}")
        })));
        let table = match table.map_err(Failure::from) {
            // The others wait for what this rank no longer does.
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
        };
        warn(report.warnings());
        if !args.json {
            print(&report.text())?;
        }
        Ok(Some(report.json()))
    }
}

/// What this rank has got ready, if all have; the failure of the first that has not is for that
/// rank to tell.
fn agreed<T>(ready: Result<T, Failure>, ranks: &dyn Ranks) -> Result<T, Failure> {
    match ranks.first_of(ready.is_err()) {
        Some(first) if first != ranks.number() => Err(Failure::Elsewhere),
        _ => ready,
    }
}

/// Whether this rank bakes what rank 0 bakes: machines may hold another mesh under the same name,
/// or another program.
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

/// What `--method auto` decided, where that is not what the other options suggest; the report names
/// the method anyway.
fn method_warning(args: &TraceArgs, prepared: &Prepared, plan: &Plan) -> Vec<String> {
    let refusal = plan.exact_cell(prepared).err();
    let asks_for_rays = args.rays.is_some() || args.tolerance.is_some();
    match (args.method, refusal) {
        (Method::Auto, Some(reason)) => vec![format!("--method auto traces rays: {reason}")],
        (Method::Auto | Method::Exact, None)
            if plan.scene.deviations != Record::Auto && !plan.is_azimuth_mean() =>
        {
            vec![
                "the exact method says where each path goes: --deviations has no effect; give \
                --method rays to use it"
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
