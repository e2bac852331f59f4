//! `fit plan`: says which photographs to take.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use tables::cli as terminal;

use estimator::result::ResultFile;
use tables::{Outputs, Table};

use crate::cli::estimate::read_channel;
use crate::cli::failure::Failure;
use crate::cli::output;
use lab::plan::{Apart, Expected, Photograph, Plan, Planned, chi_square, plan};

/// Says which photographs tell a sheet's c, a and mu best, and what errors to expect.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The errors are those that `fit estimate` reaches on photographs that follow the
model. The plan lowers them over the whole range of what you believe.

Example (PLAN.toml):
  photographs = 8                    # without that of the source edge
  minimise = [\"c_mm\", \"mu\"]          # if left out, all that the kernel has
  tell_apart = [\"eq1\", \"angular\"]    # may be left out
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
tell_apart is for photographs that tell the believed kernel from the other one;
without minimise nothing else counts. --given has no part in it.

  fit plan plan.toml --table pair.h5 -o planned.toml --report planned.html
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
    /// Page to print: the photographs with boxes to tick, the errors to expect, and what further
    /// photographs would bring.
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
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
    let report = terminal::reserve(arguments.report.as_deref(), &mut outputs)?;
    let given = arguments.given.as_deref();
    let given = given.map(|file| read_channel(file, None)).transpose()?;
    let table = tables::read(&arguments.table)?;
    let made = made(arguments, &table, given.as_ref())?;
    terminal::warn(&made.warnings);
    if arguments.output.is_some() {
        terminal::deliver(&made.manifest, output)?;
    }
    if arguments.report.is_some() {
        let command = output::command_line(std::env::args_os());
        terminal::deliver(&made.page(&command), report)?;
    }
    Ok(terminal::print(&if arguments.json {
        output::json(&made.planned)
    } else {
        text(&made.planned)
    })?)
}

/// A plan, with its manifest and with warnings about what it builds on.
pub(in crate::cli) struct Made {
    pub planned: Planned,
    pub manifest: String,
    pub warnings: Vec<String>,
    title: String,
}

impl Made {
    /// Returns the page to print; `command` is said to have made it.
    pub(in crate::cli) fn page(&self, command: &str) -> String {
        pictures::plan::page(&self.planned, &self.title, command)
    }
}

/// Makes a plan.
///
/// # Errors
/// Fails as [`run`] does.
pub(in crate::cli) fn made(
    arguments: &Arguments,
    table: &Table,
    given: Option<&ResultFile>,
) -> Result<Made, Failure> {
    let mut asked = Plan::load(&arguments.plan, given)?;
    let mut warnings = given.map_or_else(Vec::new, |result| asked.follow(result));
    let pool = terminal::pool(arguments.threads)?;
    let planned = pool.install(|| plan(&asked, table, given))?;
    warnings.extend(planned.warnings.iter().cloned());
    Ok(Made {
        manifest: planned.manifest(&asked.camera),
        planned,
        warnings,
        title: arguments.plan.display().to_string(),
    })
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
    if let [believed, _] = &planned.apart[..] {
        text += &format!(
            "\ntelling {} from {}{}middle     least   as many, spread evenly\n",
            believed.right.name(),
            believed.wrong.name(),
            " ".repeat(18 - believed.right.name().len() - believed.wrong.name().len()),
        );
        for (own, even) in planned.apart.iter().zip(&planned.even_apart) {
            text += &told_apart(own, even);
        }
    }
    if let Some(now) = &planned.now {
        text += &format!("\nof the given result alone: {}\n", by_kind(now));
    }
    text += &format!("\n{}\n", planned.conditions());
    text += "\nwith further photographs:\n";
    for (number, further) in (photographs.len() + 1..).zip(&planned.further) {
        let own = row(number, &further.photograph);
        let apart = further.chi2.map_or(String::new(), |own| {
            format!(", chi-square {}", chi_square(own))
        });
        text += &format!("{own}  {}{apart}\n", by_kind(&further.expected));
    }
    text
}

/// Returns two rows: how far chi-square tells that a kernel is right, and how likely an estimate names
/// it.
fn told_apart(own: &Apart, even: &Apart) -> String {
    let right = own.right.name();
    let chi2 = [own.chi2, even.chi2].map(|own| [own.middle, own.least]);
    let chance = [own.chance, even.chance].map(|own| [own.middle, own.least]);
    let row = |what: &str, cells: [[f64; 2]; 2], cell: fn(f64) -> String| {
        let [[a, b], [c, d]] = cells.map(|own| own.map(cell));
        format!(
            "{:<25}{a:>9}{b:>10}{c:>12}{d:>10}\n",
            format!("{right} right: {what}")
        )
    };
    row("chi-square", chi2, chi_square)
        + &row("named", chance, |chance| format!("{:.1} %", 100.0 * chance))
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
    let all = Expected::by_kind(expected).into_iter();
    let all = all.map(|(kind, error)| format!("{} {}", kind.name(), percent(error)));
    all.collect::<Vec<String>>().join(", ")
}

/// Returns a relative error in percent.
fn percent(share: Option<f64>) -> String {
    share.map_or_else(
        || "unknown".into(),
        |share| format!("{:.3} %", 100.0 * share),
    )
}
