//! `fit study`: measures how good the estimates are.

mod all;
mod mistaken;
mod written;

use std::fmt::Write;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Instant;
use tables::cli as terminal;

use tables::{Outputs, Table};

use crate::cli::failure::Failure;
use crate::cli::host::Host;
use crate::cli::lab::study::all::run_all;
use crate::cli::lab::study::mistaken::Mistaken;
use crate::cli::lab::study::written::{spreadsheet, table_of};
use crate::cli::options::expected;
use crate::cli::options::terms::Terms;
use crate::cli::options::{forward, sampled};
use crate::cli::output;
use estimator::estimate::Forward;
use estimator::estimate::Kind;
use estimator::estimate::Progress;
use estimator::estimate::Scene;
use estimator::estimate::search::select::select;
use lab::study::Ranges;
use lab::study::Summary;
use lab::study::refused;
use lab::study::{Speed, speed};
use lab::study::{Study, photographs};
use lab::study::{choice, trial};
#[cfg(feature = "full")]
use pictures::report::picture;

/// Measures how good estimates are: against the Cramer-Rao bound or a known truth.
///
/// The errors of given photographs are compared with the Cramer-Rao bound, those of renders with
/// the closed form (--forward render), and those of simulated campaigns with the truth (--ranges).
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The Cramer-Rao bound is the smallest standard deviation that any unbiased
estimate from the same pixels can have. Place, angle, plateaus and light
gradient of each photograph count as unknown.

With --ranges, campaigns are drawn, photographed in memory, fitted by the
losses mtf and edge, and compared with their truth. A campaign counts if its
bound on c is below 10 %. The table must be of the ideal cell that the ranges
name. All keys of RANGES.toml may be left out. These are the values that they
then have, except for light:
  refractive_index = 1.49                 # behind the flat front
  pair = true                             # cell: triangular-pair, or triangular
  lobe = \"radial\"
  a_per_mm = { from = 1.5, to = 8.0 }     # all ranges evenly in the logarithm
  c_mm = { from = 0.05, to = 0.5 }
  mu = { from = 0.2, to = 0.8 }
  photographs = { from = 2, to = 20 }     # at directions of the table
  electrons = { from = 500, to = 40000 }  # at full scale
  floating_distance_mm = { from = 100, to = 400 }
  light = { from = 0.001, to = 0.03 }     # uneven light; even if left out
  [camera]                                # other keys: fit simulate --help
  width = 192
  height = 128
  pixel_pitch_mm = 0.08
With --choice, the terms are drawn too and left open. The study then says how
often the estimate chose the right terms. Its keys, with the values if left
out:
  kernels = [\"eq1\", \"angular\", \"shift\", \"lobe\"]  # \"wave\" needs wavelength_nm
  a_fall = { from = 0.005, to = 1.5 }     # fall of ln a from 0 to 45 degrees,
                                          # in half of the campaigns
  mu_fall = { from = 0.0005, to = 0.5 }   # fall of ln mu, likewise

Examples:
  fit study captures.toml --table pair.h5 --kernel eq1 --per-angle a,mu \\
      --plot speed.svg
  fit study --ranges ranges.toml --table pair.h5 --campaigns 20 \\
      --csv trials.csv --plot study.svg
  fit study --ranges ranges.toml --table pair.h5 --campaigns 5 --choice
  fit study captures.toml --table pair.h5 --forward render --samples 1,4 \\
      --randomisations 2 --plot forward.svg

Words and formulas: fit/doc/model.md")]
pub(crate) struct Arguments {
    /// Manifest of the photographs that are studied (captures.toml).
    #[arg(required_unless_present = "ranges", conflicts_with = "ranges")]
    pub captures: Option<PathBuf>,
    /// Ray-shift table of the sheet, from `bake trace`.
    #[arg(long, value_name = "TABLE.h5")]
    pub table: PathBuf,
    /// Table of another cell, which is tried where a fit of `--mistakes` is not good.
    #[arg(
        long,
        value_name = "TABLE.h5",
        requires = "mistakes",
        help_heading = "Drawn campaigns"
    )]
    pub other_table: Vec<PathBuf>,
    /// Terms of the model.
    #[command(flatten)]
    pub terms: Terms,
    /// Ranges from which campaigns are drawn, as TOML.
    ///
    /// The campaigns take the place of given photographs.
    #[arg(long, value_name = "RANGES.toml", help_heading = "Drawn campaigns")]
    pub ranges: Option<PathBuf>,
    /// Number of campaigns.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1900,
        requires = "ranges",
        help_heading = "Drawn campaigns",
        value_parser = terminal::whole::<u64>(1..)
    )]
    pub campaigns: u64,
    /// Seed of all draws, and of the samples of a render.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        help_heading = "Drawn campaigns",
        value_parser = terminal::whole::<u64>(0..)
    )]
    pub seed: u64,
    /// Counts how often the planted terms are chosen.
    ///
    /// Kernels and sharings are drawn too, and are left open in the fit (auto).
    #[arg(long, requires = "ranges", help_heading = "Drawn campaigns")]
    pub choice: bool,
    /// Counts how often a mistake is noticed.
    ///
    /// Every second campaign has one planted mistake in its manifest, its table or its cell. Each
    /// campaign has one azimuth.
    #[arg(
        long,
        requires = "ranges",
        conflicts_with = "choice",
        help_heading = "Drawn campaigns"
    )]
    pub mistakes: bool,
    /// File that receives one row for each campaign, as CSV.
    #[arg(
        long,
        value_name = "FILE",
        requires = "ranges",
        conflicts_with = "choice",
        help_heading = "Drawn campaigns"
    )]
    pub csv: Option<PathBuf>,
    /// File that receives the study as a picture, .svg.
    ///
    /// For drawn campaigns it shows errors and coverage. For given photographs and renders it
    /// shows seconds against error.
    #[cfg(feature = "full")]
    #[arg(long, value_name = "FILE", conflicts_with = "choice")]
    pub plot: Option<PathBuf>,
    /// Samples in place of the closed form.
    #[command(flatten)]
    pub forward: forward::Renders,
    /// Prints one JSON object in place of a table.
    #[arg(long, help_heading = "Output and threads")]
    pub json: bool,
    /// Number of threads; one per core if left out.
    #[arg(
        long,
        value_name = "N",
        help_heading = "Output and threads",
        value_parser = terminal::whole::<NonZeroUsize>(1..)
    )]
    pub threads: Option<NonZeroUsize>,
}

/// Runs the verb.
///
/// # Errors
/// Fails if the manifest, a photograph, the ranges or the table cannot be used, if an estimate of
/// given photographs fails, or if an output cannot be written.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    Ok(terminal::print(&text(arguments, Host::Terminal)?)?)
}

/// Runs the study, and returns what it found as text or JSON.
///
/// # Errors
/// Fails as [`run`] does, and returns [`Failure::Stopped`] if the host stopped the study.
pub(in crate::cli) fn text(arguments: &Arguments, host: Host<'_>) -> Result<String, Failure> {
    let pool = terminal::pool(arguments.threads)?;
    Ok(match (&arguments.ranges, &arguments.captures) {
        (Some(ranges), _) => drawn(arguments, ranges, &pool, host)?,
        (None, Some(captures)) if arguments.forward.forward == Some(Forward::Render) => {
            rendered(arguments, captures, &pool)?
        }
        (None, Some(captures)) => {
            let (campaign, expected) = expected::campaign(captures, None)?;
            #[cfg(feature = "full")]
            let mut outputs = Outputs::beside([captures.as_path(), &arguments.table]);
            #[cfg(feature = "full")]
            let picture = terminal::reserve_plot(arguments.plot.as_deref(), &mut outputs)?;
            let table = expected.read(&arguments.table)?;
            let open = arguments.terms.candidates("fit study")?;
            let start = Instant::now();
            let scene = pool.install(|| Scene::load(&campaign, &table))?;
            let seconds = start.elapsed().as_secs_f64();
            let (open, _) = open.possible(&scene, &table, captures)?;
            let study = pool.install(|| photographs(&scene, seconds, &open))?;
            #[cfg(feature = "full")]
            if let Some(output) = picture {
                output.commit(picture::photographs(&study).as_bytes())?;
            }
            if arguments.json {
                output::json(&study)
            } else {
                bounds(&study)
            }
        }
        (None, None) => String::new(),
    })
}

/// Studies estimates by samples: their seconds and their errors against the closed form.
fn rendered(
    arguments: &Arguments,
    captures: &Path,
    pool: &rayon::ThreadPool,
) -> Result<String, Failure> {
    let open = arguments.terms.candidates("fit study")?;
    let open = sampled::only(open, None, "fit study")?;
    let (campaign, expected) = expected::campaign(captures, None)?;
    #[cfg(feature = "full")]
    let mut outputs = Outputs::beside([captures, &arguments.table]);
    #[cfg(feature = "full")]
    let picture = terminal::reserve_plot(arguments.plot.as_deref(), &mut outputs)?;
    let table = expected.read(&arguments.table)?;
    let speed = pool.install(|| -> Result<Speed, Failure> {
        let scene = Scene::load(&campaign, &table)?;
        let choice = select(&scene, Kind::Mtf, &open, &Progress::SILENT)?
            .best
            .choice;
        let samplings = arguments.forward.samplings(arguments.seed);
        let randomisations = arguments.forward.randomisations;
        Ok(speed(&scene, &table, choice, &samplings, randomisations)?)
    })?;
    #[cfg(feature = "full")]
    if let Some(output) = picture {
        output.commit(picture::speed(&speed).as_bytes())?;
    }
    Ok(if arguments.json {
        output::json(&speed)
    } else {
        forward::table(&speed)
    })
}

fn bounds(study: &Study) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "model: {} (kernel {})\n\
         {} photographs, measured in {:.3} s\n\
         bound: least standard error that these pixels allow (Cramer-Rao), % of the estimate",
        study.kernel.description(),
        study.kernel.name(),
        study.photographs,
        study.seconds_to_measure
    );
    let _ = writeln!(
        text,
        "{:<20}{:>11}{:>13}{:>15}{:>15}",
        "", "estimate", "bound", "edge / bound", "mtf / bound"
    );
    for p in &study.parameters {
        let _ = writeln!(
            text,
            "{:<20}{:>11.5}{:>11.4} %{:>15.3}{:>15.3}",
            p.name,
            p.value,
            100.0 * p.bound / p.value,
            p.edge / p.bound,
            p.mtf / p.bound
        );
    }
    let _ = writeln!(
        text,
        "{:<10}{:<6}{:>9}{:>26}{:>15}",
        "kernel", "loss", "seconds", "chi-square / freedom", "error / bound"
    );
    for fit in &study.fits {
        let error = fit.error_over_bound;
        let _ = writeln!(
            text,
            "{:<10}{:<6}{:>9.4}{:>26.3}{:>15}",
            fit.kernel.name(),
            fit.loss.name(),
            fit.seconds,
            fit.reduced_chi2,
            error.map_or("-".into(), |error| format!("{error:.3}"))
        );
    }
    text
}

fn drawn(
    arguments: &Arguments,
    file: &Path,
    pool: &rayon::ThreadPool,
    host: Host<'_>,
) -> Result<String, Failure> {
    let ranges = Ranges::load(file)?;
    let table = tables::read(&arguments.table)?;
    let directions = checked_directions(&ranges, &table, &arguments.table)?;
    let mut outputs = Outputs::beside([file, &arguments.table]);
    let csv = terminal::reserve(arguments.csv.as_deref(), &mut outputs)?;
    #[cfg(feature = "full")]
    let picture = terminal::reserve_plot(arguments.plot.as_deref(), &mut outputs)?;
    if arguments.choice {
        let (trials, refused) = run_all(arguments.campaigns, pool, host, |index| {
            let params = ranges.open_campaign(arguments.seed, index, &directions);
            choice::run(&params, index, &table)
        })?;
        let summary = choice::Summary::new(&trials, refused);
        return Ok(if arguments.json {
            output::json(&summary)
        } else {
            choices(&summary)
        });
    }
    if arguments.mistakes {
        let study = Mistaken {
            campaigns: arguments.campaigns,
            seed: arguments.seed,
            other_tables: &arguments.other_table,
            is_json: arguments.json,
            ranges: &ranges,
            table: &table,
            directions: &directions,
        };
        let (text, rows) = study.run(pool, host)?;
        if let Some(output) = csv {
            output.commit(rows.as_bytes())?;
        }
        return Ok(text);
    }
    let (trials, refused) = run_all(arguments.campaigns, pool, host, |index| {
        let params = ranges.campaign(arguments.seed, index, &directions);
        trial::run(&params, index, &table)
    })?;
    if let Some(output) = csv {
        output.commit(spreadsheet(&trials).as_bytes())?;
    }
    let summary = Summary::new(&trials, refused);
    #[cfg(feature = "full")]
    if let Some(output) = picture {
        output.commit(picture::drawn(&summary).as_bytes())?;
    }
    Ok(if arguments.json {
        output::json(&summary)
    } else {
        table_of(&summary)
    })
}

fn choices(summary: &choice::Summary) -> String {
    let mut text = format!(
        "{} campaigns, {}\n\
         told: the planted terms should win by {sure} standard deviations or more\n\
         hidden: simpler terms should win by {sure} standard deviations or more\n\
         between: all other campaigns\n",
        summary.campaigns,
        refused::line(&summary.refused),
        sure = choice::SURE
    );
    let _ = writeln!(
        text,
        "{:<22}{:>10}{:>20}{:>20}{:>20}",
        "planted", "campaigns", "told: chosen", "hidden: simpler", "between: either"
    );
    let share = |[all, good]: [usize; 2]| match all {
        0 => "-".to_owned(),
        _ => format!("{good}/{all} {:.1} %", 100.0 * good as f64 / all as f64),
    };
    for row in &summary.rows {
        let _ = writeln!(
            text,
            "{:<22}{:>10}{:>20}{:>20}{:>20}",
            row.planted,
            row.campaigns,
            share(row.told),
            share(row.hidden),
            share(row.between)
        );
    }
    for row in &summary.bounds {
        let _ = writeln!(
            text,
            "{:<22}{:>10} without a number, {} with a bound, which holds in {}",
            row.name,
            row.campaigns,
            row.bounded,
            share([row.bounded, row.holds])
        );
    }
    text + &refused::examples(&summary.refused)
}

/// Returns the directions to photograph, after a check that the table is of the simulated cell.
///
/// # Errors
/// Returns [`Failure::OtherCell`] if the retroreflected fraction of the table differs from that of
/// the simulated cell in a direction, or if no direction can be photographed.
fn checked_directions(
    ranges: &Ranges,
    table: &Table,
    path: &Path,
) -> Result<Vec<[f64; 2]>, Failure> {
    /// Largest relative difference of the retroreflected fraction, for tables of rays.
    const SAME: f64 = 0.01;
    let directions = ranges.directions(table);
    let same = |&[incidence, azimuth]: &[f64; 2]| {
        let eta = ranges.eta([incidence, azimuth]);
        table
            .direction(incidence, Some(azimuth))
            .is_ok_and(|found| (found.retroreflected / eta - 1.0).abs() < SAME)
    };
    if directions.is_empty() || !directions.iter().all(same) {
        return Err(Failure::OtherCell {
            table: path.to_owned(),
            refractive_index: ranges.refractive_index,
            design: if ranges.pair {
                "triangular-pair"
            } else {
                "triangular"
            },
        });
    }
    Ok(directions)
}
