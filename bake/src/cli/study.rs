//! `bake study`: its options and what is done with them.

use crate::cli::cell::CellArgs;
use crate::cli::failure::Failure;
use crate::cli::progress::Progress;
use crate::plan::{Request, default};
use crate::study::{StudyPlan, picture, report, study};
use clap::Args;
use std::path::PathBuf;
use tables::Outputs;
use tables::cli::{print, reserve_plot, warn};
use tables::options::{Back, SceneOptions};

/// Options of `bake study`.
#[derive(Debug, Args)]
pub(crate) struct StudyArgs {
    /// Mesh: .obj, .gltf or .glb
    mesh: PathBuf,
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
    /// Most rays per direction; the study begins with 1024 and takes four times as many each time
    #[arg(long, value_name = "N", default_value_t = default::RAYS)]
    rays: u64,
    /// Histogram bins along u and along v
    #[arg(long, value_name = "N", default_value_t = default::BINS)]
    bins: usize,
    /// The histogram covers u, v from -RANGE to RANGE, edge lengths
    #[arg(long, default_value_t = default::RANGE, allow_negative_numbers = true)]
    range: f64,
    #[command(flatten)]
    cell: CellArgs,
    /// Seed of the samples of the first repeat; each further repeat takes the next
    #[arg(long, default_value_t = default::SEED)]
    seed: u64,
    /// Threads [default: all processors]
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Bakes of each kind: seconds are their median, errors their mean
    #[arg(long, value_name = "N", default_value_t = study::default::REPEATS)]
    repeats: usize,
    /// L1 error of the worst direction that the time is asked for
    #[arg(long, value_name = "E", default_value_t = study::default::TARGET, allow_negative_numbers = true)]
    target: f64,
    /// Leaves out bakes that are expected to take longer than this, s, and all with more rays
    #[arg(long, value_name = "SECONDS", default_value_t = study::default::LONGEST_SECONDS, allow_negative_numbers = true)]
    longest: f64,
    /// Writes the figures as comma-separated values
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// Draws error against rays and against seconds into a .png or .svg file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs `bake study`.
pub(crate) fn run(args: &StudyArgs) -> Result<(), Failure> {
    let study = StudyPlan::new(study::StudyRequest {
        trace: Request {
            incidence: args.incidence.clone(),
            azimuth: args.azimuth.clone(),
            refractive_index: args.refractive_index,
            back: args.back,
            rays: Some(args.rays),
            bins: args.bins,
            range: args.range,
            seed: args.seed,
            threads: args.threads,
            ..Request::default()
        },
        repeats: args.repeats,
        target: args.target,
        longest_seconds: args.longest,
    })?;
    // Minutes of work are not lost to a folder that is not there.
    let mut outputs = Outputs::beside([args.mesh.as_path()]);
    let picture = reserve_plot(args.plot.as_deref(), &mut outputs)?;
    let csv = args
        .csv
        .as_deref()
        .map(|file| outputs.reserve(file))
        .transpose()?;
    let cell = args.cell.load(&args.mesh, &SceneOptions::default())?;
    warn(&cell.warnings);
    let progress = Progress::of_study();
    let study = study.run(&cell, &|name, done, all| progress.step(name, done, all))?;
    progress.finish();
    if let Some(csv) = csv {
        csv.commit(report::csv(&study).as_bytes())?;
    }
    if let Some((file, output)) = picture {
        output.commit(&picture::draw(&study, file)?)?;
    }
    Ok(print(&if args.json {
        report::json(&study)
    } else {
        report::text(&study)
    })?)
}
