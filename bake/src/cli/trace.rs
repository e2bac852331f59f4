//! `bake trace`: reads its options, bakes one table for each wavelength, and reports.

use crate::cell::Prepared;
use crate::cli::calls::Caller;
use crate::cli::cell::{CellArgs, IndexArgs};
use crate::cli::display::ProgressDisplay;
use crate::cli::report;
use crate::error::Error;
use crate::optics::material;
use crate::plan::{Plan, Request, heading};
use crate::run::{Bake, Launched, Progress, Ranks, SavedFile, Saves, agreed, remarks, saves};
use clap::Args;
use meshes::Mesh;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use tables::cli::{fail, in_a_line, print, warn};
use tables::{Output, Outputs, Table};

/// Options of `bake trace`.
#[derive(Debug, Args)]
pub(crate) struct TraceArgs {
    /// Mesh file of one cell: .obj, .gltf, .glb, .stl or .ply
    mesh: PathBuf,
    /// Table to write, an HDF5 file
    ///
    /// With several wavelengths, write {nm} in the name where the wavelength belongs.
    #[arg(short, long, value_name = "TABLE.h5")]
    output: PathBuf,
    #[command(flatten)]
    index: IndexArgs,
    #[command(flatten)]
    request: Request,
    /// Wavelengths in vacuum, nm
    ///
    /// Each wavelength has a table of its own.
    #[arg(
        long,
        alias = "wavelengths-nm",
        value_name = "NM,..",
        value_delimiter = ',',
        help_heading = heading::MATERIAL
    )]
    wavelength_nm: Vec<f64>,
    /// Metal of the mirrors: aluminium, silver or N,K
    ///
    /// N,K is the complex refractive index, such as 0.96,6.7. A name needs --wavelength-nm. Needs
    /// --losses fresnel and excludes --reflectance.
    #[arg(long, value_name = "NAME", allow_hyphen_values = true, help_heading = heading::MATERIAL)]
    metal: Option<String>,
    #[command(flatten, next_help_heading = heading::CELL)]
    cell: CellArgs,
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
}

impl TraceArgs {
    /// Returns what is asked of the table of one wavelength (nm), or of the only table.
    fn request(&self, wavelength_nm: Option<f64>) -> Result<Request, Error> {
        let metal = self.metal.as_deref();
        let metal = metal.map(|text| material::metal(text, wavelength_nm));
        Ok(Request {
            refractive_index: self.index.at(wavelength_nm)?,
            metal: metal.transpose()?,
            wavelength_nm,
            ..self.request.clone()
        })
    }

    /// Returns the tables to write, each with its wavelength in nm if one is named.
    fn tables(&self) -> Result<Vec<(PathBuf, Option<f64>)>, Error> {
        let name = self.output.to_string_lossy();
        let named = name.contains("{nm}");
        match &self.wavelength_nm[..] {
            [] if named => Err(Error::Usage(format!(
                "-o {name}: {{nm}} stands for a wavelength, but no wavelength is given; give \
                --wavelength-nm, or a name without {{nm}}"
            ))),
            [] => Ok(vec![(self.output.clone(), None)]),
            [_, _, ..] if !named => Err(Error::Usage(format!(
                "--wavelength-nm names {} wavelengths, and each of them has a table of its own, \
                but -o {name} names one file only; write {{nm}} where the wavelength belongs in \
                the name, such as sheet-{{nm}}.h5",
                self.wavelength_nm.len()
            ))),
            wavelengths
                if (1..wavelengths.len()).any(|k| wavelengths[..k].contains(&wavelengths[k])) =>
            {
                Err(Error::Usage(format!(
                    "--wavelength-nm {wavelengths:?}: a wavelength is given twice; give each \
                    wavelength once, because each has a table of its own"
                )))
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
) -> Result<(), Error> {
    if args.request.shard.is_none() {
        Launched::check(launched, ranks)?;
    }
    let (prepared, plans) = agreed(inputs(args, None), ranks)?;
    let jobs = agreed(jobs(args, &prepared, &plans, ranks.leads()), ranks)?;
    for job in &jobs {
        agreed(job.bake.is_that_of_all(ranks), ranks)?;
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
///
/// A `mesh` in memory takes the place of the file.
fn inputs(args: &TraceArgs, mesh: Option<&Mesh>) -> Result<(Prepared, Vec<Planned>), Error> {
    let plans = args
        .tables()?
        .into_iter()
        .map(|(file, nm)| Ok((file, Plan::new(&args.request(nm)?)?)))
        .collect::<Result<Vec<_>, Error>>()?;
    let cell = match mesh {
        Some(mesh) => args.cell.of_mesh(mesh, &args.mesh, &args.request.scene)?,
        None => args.cell.load(&args.mesh, &args.request.scene)?,
    };
    Ok((Prepared::new(cell), plans))
}

/// Bakes the first table of `args` for another program, and returns it with the remarks. Nothing is
/// printed or written.
///
/// # Errors
/// Fails as [`run`] does, and if the caller stopped the bake.
pub(super) fn called(
    args: &TraceArgs,
    mesh: Option<&Mesh>,
    caller: &Caller,
) -> Result<(Table, Vec<String>), Error> {
    let (prepared, plans) = inputs(args, mesh)?;
    let (_, plan) = plans.first().ok_or(Error::Elsewhere)?;
    let mut remarks = remarks::of_plans(&args.request, &prepared, &[plan]);
    let bake = Bake::new(&prepared, plan, Progress::none().stopped_by(caller.stop))?;
    let (all, done) = (bake.all_rays(), AtomicU64::new(0));
    let told = |rays| (caller.told)(rays + done.fetch_add(rays, Ordering::Relaxed), all);
    let table = bake.table(Progress::new(&told).stopped_by(caller.stop))?;
    remarks.extend(remarks::of_table(&table, prepared.cell()));
    Ok((table, remarks))
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
) -> Result<Vec<Job<'a>>, Error> {
    let mut outputs = Outputs::beside([args.mesh.as_path()]);
    if leads {
        let plans: Vec<&Plan> = plans.iter().map(|(_, plan)| plan).collect();
        warn(remarks::of_plans(&args.request, prepared, &plans));
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
            bake: Bake::new(prepared, plan, Progress::none())?,
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
    fn run(self, args: &TraceArgs, ranks: &dyn Ranks) -> Result<Option<serde_json::Value>, Error> {
        let display = ProgressDisplay::new(&self.bake, ranks.leads());
        // A table that is written through a link is saved where the link leads, as it is read.
        let reserved = self.output.as_ref().map(Output::path);
        let saved = SavedFile::of(reserved.unwrap_or(self.file));
        let mut unsaved = None;
        // A disk that is full now may have room at the end. So the bake continues if a save fails,
        // and the failure is printed once.
        let mut save = |table: &Table| unsaved = unsaved.take().or(saved.write(table).err());
        let saves = Saves::new(self.before, args.save_every, &mut save);
        let advance = |rays| display.advance(rays);
        let baked = self.bake.run(Progress::new(&advance), Some(saves), ranks);
        display.finish();
        warn(Vec::from_iter(unsaved.map(|error| {
            format!("the bake could not be saved for --resume: {error}")
        })));
        let baked = match baked {
            // The other ranks wait for this one, so all of them are stopped.
            Err(failure) if ranks.count() > 1 => {
                fail(&failure);
                ranks.abort(failure.code());
                return Err(Error::Elsewhere);
            }
            baked => baked?,
        };
        let (Some(baked), Some(output)) = (baked, self.output) else {
            return Ok(None);
        };
        let before = content(output.path());
        tables::commit(&baked.table, output)?;
        saved.remove();
        let is_other = |(hash, _): &(String, String)| *hash != baked.table.content_hash();
        let report = report::Trace {
            baked: &baked,
            file: self.file,
            between: self.bake.between(&baked.table),
            edge_length_from: self.bake.prepared.cell().edge_length_from,
            replaced: before.filter(is_other).map(|(_, words)| words),
        };
        warn(remarks::of_table(&baked.table, self.bake.prepared.cell()));
        if !args.json {
            print(&report.text())?;
        }
        Ok(Some(report.json()))
    }
}

/// Returns the content hash of the table at a place, and a description of what is there; `None` if
/// nothing is.
fn content(file: &Path) -> Option<(String, String)> {
    if !file.exists() {
        return None;
    }
    let Ok(table) = tables::read(file) else {
        return Some((String::new(), "a file that was no table".into()));
    };
    let (incidences, azimuths) = table.axes.shape();
    let hash = table.content_hash();
    let words = format!(
        "a table of {}, {} directions, content {}",
        in_a_line(&table.provenance.design),
        incidences * azimuths,
        hash.chars().take(12).collect::<String>()
    );
    Some((hash, words))
}

/// Reads what an interrupted bake of the same table has saved, if `resume` asks for it.
///
/// Without `resume`, warns that a saved bake is there and returns `None`.
fn saved_before(saved: &SavedFile, resume: bool) -> Result<Option<Table>, Error> {
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
