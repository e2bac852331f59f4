//! `bake study`: reads its options, runs the study, and writes what it measured.

use crate::cli::cell::CellArgs;
use crate::cli::display::ProgressDisplay;
use crate::error::Error;
use crate::plan::heading;
use crate::plan::{Request, default};
use crate::study::{StudyPlan, picture, report, study};
use clap::Args;
use std::path::PathBuf;
use tables::Outputs;
use tables::cli::{number, print, reserve_plot, warn, whole};
use tables::options::{Back, SceneOptions};

/// Options of `bake study`.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub(crate) struct StudyArgs {
    /// Mesh file of one cell: .obj, .gltf, .glb, .stl or .ply
    mesh: PathBuf,
    /// Refractive index behind the front face [default: the file's, else 1]
    #[arg(long, value_parser = number, value_name = "M")]
    refractive_index: Option<f64>,
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
    /// A list such as 0,30; start:stop:step; or mean for the average over all azimuths.
    #[arg(
        long,
        value_name = "ANGLES",
        default_value = default::AZIMUTH,
        allow_hyphen_values = true
    )]
    azimuth: String,
    /// Largest number of rays per direction
    ///
    /// The study begins with 1024 rays and takes four times as many each time.
    #[arg(
        long,
        value_name = "N",
        default_value_t = default::RAYS,
        help_heading = heading::MEASUREMENT,
        value_parser = whole::<u64>(0..)
    )]
    rays: u64,
    /// Bakes of each kind
    ///
    /// The seconds are their median, and the errors their mean.
    #[arg(
        long,
        value_name = "N",
        default_value_t = study::default::REPEATS,
        help_heading = heading::MEASUREMENT,
        value_parser = whole::<usize>(0..)
    )]
    repeats: usize,
    /// L1 error for which the study reports the time
    ///
    /// The error of the worst direction counts. It is a sum of probabilities: above 0, at most 2.
    #[arg(
        long,
        value_parser = number,
        value_name = "E",
        default_value_t = study::default::TARGET,
        help_heading = heading::MEASUREMENT
    )]
    target: f64,
    /// Longest expected time of a bake, seconds
    ///
    /// A bake that is expected to take longer is left out, and so are those with more rays.
    #[arg(
        long,
        value_parser = number,
        value_name = "SECONDS",
        default_value_t = study::default::LONGEST_SECONDS,
        help_heading = heading::MEASUREMENT
    )]
    longest: f64,
    /// Seed of the samples of the first repeat
    ///
    /// Each further repeat takes the next seed.
    #[arg(
        long,
        default_value_t = default::SEED,
        help_heading = heading::MEASUREMENT,
        value_parser = whole::<u64>(0..)
    )]
    seed: u64,
    /// Histogram bins along u and along v
    #[arg(
        long,
        value_name = "N",
        default_value_t = default::BINS,
        help_heading = heading::ACCURACY,
        value_parser = whole::<usize>(0..)
    )]
    bins: usize,
    /// Half width of the histogram, edge lengths
    ///
    /// The histogram covers shifts u and v from -RANGE to RANGE.
    #[arg(
        long,
        value_parser = number,
        default_value_t = default::RANGE,
        help_heading = heading::ACCURACY
    )]
    range: f64,
    /// Backing of facets
    #[arg(long, value_enum, default_value_t = Back::Mirror, help_heading = heading::MATERIAL)]
    back: Back,
    #[command(flatten, next_help_heading = heading::CELL)]
    cell: CellArgs,
    /// Plot of error against rays and against seconds, .png or .svg
    #[arg(long, value_name = "FILE", help_heading = heading::OUTPUT)]
    plot: Option<PathBuf>,
    /// File for all measurements as comma-separated values
    #[arg(long, value_name = "FILE.csv", help_heading = heading::OUTPUT)]
    csv: Option<PathBuf>,
    /// Prints the report as one JSON object
    #[arg(long, help_heading = heading::OUTPUT)]
    json: bool,
    /// Number of threads [default: all processors]
    #[arg(
        long,
        value_name = "N",
        help_heading = heading::OUTPUT,
        value_parser = whole::<usize>(0..)
    )]
    threads: Option<usize>,
}

/// Runs `bake study`.
pub(crate) fn run(args: &StudyArgs) -> Result<(), Error> {
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
    // The outputs are reserved first: minutes of work must not be lost to a missing folder.
    let mut outputs = Outputs::beside([args.mesh.as_path()]);
    let picture = reserve_plot(args.plot.as_deref(), &mut outputs)?;
    let csv = args
        .csv
        .as_deref()
        .map(|file| outputs.reserve(file))
        .transpose()?;
    let cell = args.cell.load(&args.mesh, &SceneOptions::default())?;
    warn(&cell.warnings);
    let display = ProgressDisplay::of_steps();
    let study = study.run(&cell, &|name, done, all| display.step(name, done, all))?;
    display.finish();
    if let Some(csv) = csv {
        csv.commit(report::csv(&study).as_bytes())?;
    }
    if let Some(output) = picture {
        output.commit(picture::draw(&study).as_bytes())?;
    }
    Ok(print(&if args.json {
        report::json(&study)
    } else {
        report::text(&study)
    })?)
}
