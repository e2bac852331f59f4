//! `fit plan`: says which photographs to take.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use tables::cli as terminal;

use tables::Outputs;

use crate::cli::estimate::read_channel;
use crate::cli::failure::Failure;
use crate::cli::output;
use lab::plan::{Expected, Photograph, Plan, Planned, plan};

/// Says which photographs tell a sheet's c, a and mu best, and what errors to expect.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The errors are those that `fit estimate` reaches on photographs that follow the
model. The plan lowers them over the whole range of what you believe.

Example (PLAN.toml):
  photographs = 8                    # without that of the source edge
  minimise = [\"c_mm\", \"mu\"]          # if left out, all that the kernel has
  [beliefs]
  kernel = \"eq1\"
  c_mm = { from = 0.15, to = 0.3 }
  a_per_mm = { from = 2, to = 5 }    # a_times_r under the kernel angular
  mu = { from = 0.3, to = 0.6 }
  [choices]                          # every combination can be photographed
  floating_distance_mm = [100, 200, 400]
  incidence_deg = [0, 10, 20, 30]
  azimuth_deg = [30]
  edge = [\"tangential\", \"sagittal\"]  # may be left out

a and mu have one value per incidence, as in real sheets; per_angle = [] in
[beliefs] lets all incidences share them. [beliefs] may hold lobe, and
wavelength_nm for the kernel wave. Each combination is photographed once, or up
to `repeat` times of [choices]. [camera] takes the keys of `fit simulate`.

  fit plan plan.toml --table pair.h5 -o planned.toml
  fit plan plan.toml --table pair.h5 --given result.json

The manifest names the photographs to take; the second line says what more of
them would add to a result, and whose plan may leave [beliefs] out.

Words and formulas: fit/doc/model.md")]
pub(crate) struct Arguments {
    /// Beliefs and choices, as TOML.
    #[arg(value_name = "PLAN.toml")]
    pub plan: PathBuf,
    /// Table of the cell, with the directions of [choices].
    #[arg(long, value_name = "TABLE.h5")]
    pub table: PathBuf,
    /// Result of earlier photographs of the sheet, to which the planned ones add.
    ///
    /// A plan without [beliefs] believes it, within two standard errors on either side. The lobe, `per_angle` and `seen_in_mirror` of the plan are then those of the result. Of a
    /// parameter with one value per incidence no error is taken.
    #[arg(long, value_name = "RESULT.json")]
    pub given: Option<PathBuf>,
    /// File that receives the manifest to fill in; it must not exist yet.
    #[arg(short, long, value_name = "FILE.toml")]
    pub output: Option<PathBuf>,
    /// Prints the plan as one JSON object.
    #[arg(long)]
    pub json: bool,
    /// Number of threads; one per core if left out.
    #[arg(long, value_name = "N", value_parser = terminal::whole::<NonZeroUsize>(1..))]
    pub threads: Option<NonZeroUsize>,
}

/// Runs the verb.
///
/// # Errors
/// Fails if the plan, the table or the result cannot be used, if the table lacks a direction, or if
/// the manifest cannot be written.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    // A manifest is written by hand, so none is replaced.
    if let Some(file) = arguments.output.as_deref().filter(|file| file.exists()) {
        let message = format!("{}: exists already; name another file", file.display());
        return Err(Failure::conflict("fit plan", message));
    }
    let inputs = [&arguments.plan, &arguments.table].into_iter();
    let inputs = inputs.chain(&arguments.given).map(PathBuf::as_path);
    let mut outputs = Outputs::beside(inputs);
    let output = terminal::reserve(arguments.output.as_deref(), &mut outputs)?;
    let given = arguments.given.as_deref();
    let given = given.map(|file| read_channel(file, None)).transpose()?;
    let mut asked = Plan::load(&arguments.plan, given.as_ref())?;
    let table = tables::read(&arguments.table)?;
    if let Some(result) = &given {
        terminal::warn(asked.follow(result));
    }
    let pool = terminal::pool(arguments.threads)?;
    let planned = pool.install(|| plan(&asked, &table, given.as_ref()))?;
    if arguments.output.is_some() {
        terminal::deliver(&planned.manifest(&asked.camera), output)?;
    }
    Ok(terminal::print(&if arguments.json {
        output::json(&planned)
    } else {
        text(&planned)
    })?)
}

/// Returns the plan for a reader.
fn text(planned: &Planned) -> String {
    let Planned {
        photographs,
        candidates,
        dark,
        ..
    } = planned;
    let mut text = format!(
        "{} of {candidates} photographs that could be taken",
        photographs.len()
    );
    if *dark > 0 {
        text += &format!(" ({dark} more return no light)");
    }
    text += "\n  no.  distance (mm)  incidence  azimuth  edge across  exposure\n";
    for (number, own) in (1..).zip(photographs) {
        text += &format!("{}{:>10.3}\n", row(number, own), own.exposure);
    }
    text += "\nexpected standard errors   middle   largest   as many, spread evenly\n";
    for (own, even) in planned.expected.iter().zip(&planned.even) {
        text += &format!(
            "{:<25}{:>9}{:>10}{:>12}{:>10}\n",
            own.parameter.to_string(),
            percent(own.middle),
            percent(own.largest),
            percent(even.middle),
            percent(even.largest)
        );
    }
    if let Some(now) = &planned.now {
        text += &format!("\nof the given result alone: {}\n", by_kind(now));
    }
    text += "\nwith further photographs:\n";
    for (number, further) in (photographs.len() + 1..).zip(&planned.further) {
        let own = row(number, &further.photograph);
        text += &format!("{own}  {}\n", by_kind(&further.expected));
    }
    text
}

/// Returns the start of a photograph's row.
fn row(number: usize, own: &Photograph) -> String {
    format!(
        "{number:>5}{:>15}{:>10}°{:>8}°  {:<11}",
        own.floating_distance_mm,
        own.incidence_deg,
        own.azimuth_deg,
        own.edge.name()
    )
}

/// Returns the errors of each kind of parameter, as the root of the mean square.
fn by_kind(expected: &[Expected]) -> String {
    let kinds = expected.chunk_by(|a, b| a.parameter.kind == b.parameter.kind);
    let all = kinds.map(|own| {
        let squares: Option<f64> = own.iter().map(|own| own.middle.map(|v| v * v)).sum();
        let error = squares.map(|sum| (sum / own.len() as f64).sqrt());
        format!("{} {}", own[0].parameter.kind.name(), percent(error))
    });
    all.collect::<Vec<String>>().join(", ")
}

/// Returns a relative error in percent.
fn percent(share: Option<f64>) -> String {
    share.map_or_else(
        || "unknown".into(),
        |share| format!("{:.3} %", 100.0 * share),
    )
}
