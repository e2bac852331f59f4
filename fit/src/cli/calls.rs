//! The verbs for a program that calls them in its own process, as the Python package does.
//!
//! Options enter as the words of a command line, so they have one meaning, one default and one
//! refusal everywhere. What a verb reads may lie in memory instead of in a file; a name stands in
//! the words then. Results leave as objects and as JSON, the same that the program prints. Nothing
//! is printed.

use std::collections::HashMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use tables::Table;
use tables::cli::{self as terminal, parsed};

use crate::cli::estimate::{Estimation, read_channel};
use crate::cli::failure::Failure;
use crate::cli::host::Host;
use crate::cli::lab::{plan, simulate, study};
use crate::cli::options::by_hand::Numbers;
use crate::cli::options::parse;
use crate::cli::pictures::{explore, render};
use crate::cli::{estimate, mtf, output, predict};
use edges::photographs::photo::in_memory::InMemory;
use edges::photographs::photo::picture::Picture;
use estimator::estimate::OtherTable;
use estimator::predict::Fitted;
use estimator::result::{Nominal, ResultFile};
use pictures::images::SILENT;

pub use crate::cli::host::Caller;
pub use tables::cli::Refused;

impl From<Failure> for Refused {
    fn from(failure: Failure) -> Refused {
        match failure {
            Failure::Stopped => Refused::Stopped,
            Failure::Estimator(error) if matches!(*error, estimator::Error::Cancelled(_)) => {
                Refused::Stopped
            }
            Failure::Usage(usage) => usage.into(),
            failure => Refused::Sentence(failure.to_string()),
        }
    }
}

/// Table in memory, with its name for messages.
pub type Named = (PathBuf, Arc<Table>);

/// Manifest and photographs in memory.
pub struct Campaign {
    /// Text of the manifest, as of a file captures.toml.
    pub manifest: String,
    /// Photographs that it names.
    pub photographs: Vec<InMemory>,
}

/// Measures the edge of one photograph, as `fit mtf --json` does.
///
/// # Errors
/// Returns [`Refused`] if the words cannot be used, if the photograph cannot be read or if it holds
/// no edge.
pub fn measure(words: &[OsString], held: Option<&InMemory>) -> Result<String, Refused> {
    Ok(mtf::measurement(&parsed(words)?, held)?)
}

/// Estimate, with what its report shows.
pub struct Fit {
    estimation: Estimation,
}

impl Fit {
    /// Returns the result.
    pub fn result(&self) -> &ResultFile {
        &self.estimation.result
    }

    /// Returns the report as HTML; `command` is said to have made it.
    pub fn report(&self, command: &str) -> String {
        self.estimation.report(command)
    }
}

/// Estimates a sheet, as `fit estimate` does.
///
/// `held` takes the place of the manifest, and `tables` that of the files of `--table`.
///
/// # Errors
/// Returns [`Refused`] if the words, the manifest, a photograph or a table cannot be used, if the
/// estimate fails, or if the caller stopped it.
pub fn estimate(
    words: &[OsString],
    held: Option<Campaign>,
    tables: &[Named],
    caller: Caller,
) -> Result<Fit, Refused> {
    let start = Instant::now();
    let arguments = parsed(words)?;
    let others = tables.iter().skip(1).map(|(name, table)| OtherTable {
        name: name.display().to_string(),
        table: Arc::clone(table),
    });
    let first = tables.first().ok_or_else(|| {
        Refused::Sentence("the estimate has no table; name the table of the sheet".into())
    })?;
    let inputs = estimate::Inputs {
        held: held.map(|held| {
            let named = held.photographs.into_iter();
            let photographs: HashMap<PathBuf, InMemory> =
                named.map(|held| (held.name.clone(), held)).collect();
            (held.manifest, photographs)
        }),
        table: &first.1,
        others: others.collect(),
    };
    let estimation = estimate::called(&arguments, inputs, caller, start)?;
    Ok(Fit { estimation })
}

/// Reads a result that `fit estimate -o` or [`json`] wrote; of several channels, the named one.
///
/// # Errors
/// Returns [`Refused`] if the file cannot be read or holds no such result.
pub fn read(file: &Path, channel: Option<&str>) -> Result<ResultFile, Refused> {
    Ok(read_channel(file, channel)?)
}

/// Returns the result that [`json`] made this text of.
///
/// # Errors
/// Returns [`Refused`] if the text holds no such result.
pub fn of_json(text: &str) -> Result<ResultFile, Refused> {
    serde_json::from_str(text).map_err(|error| {
        Refused::Sentence(format!(
            "the text of the result cannot be used ({error}); give what `fit estimate -o` wrote"
        ))
    })
}

/// Returns a result as the text of a RESULT.json.
pub fn json(result: &ResultFile) -> String {
    output::json(result)
}

/// Numbers of a sheet without a fit, and the pixels of its images.
#[derive(Debug, clap::Args)]
struct Sheet {
    #[command(flatten)]
    numbers: Numbers,
    #[arg(long, value_parser = parse::positive, default_value_t = 1.0)]
    pixel_pitch: f64,
}

/// Makes the result of a sheet whose numbers are given by hand, as `fit render --c` does.
///
/// # Errors
/// Returns [`Refused`] if the words cannot be used, or if nothing says what spreads the light.
pub fn sheet(words: &[OsString], table: &Table) -> Result<ResultFile, Refused> {
    let sheet: Sheet = parsed(words)?;
    Ok(sheet
        .numbers
        .result("fit predict", sheet.pixel_pitch, table)?)
}

/// Reads the table of a nominal sheet.
///
/// # Errors
/// Returns [`Refused`] if no sheet has this name.
pub fn table_of_sheet(name: &str) -> Result<Table, Refused> {
    let Some(sheet) = Nominal::named(name) else {
        let names: Vec<&str> = Nominal::all().iter().map(|sheet| sheet.name).collect();
        return Err(Refused::Sentence(format!(
            "no sheet is named {name}; take one of {}",
            names.join(", ")
        )));
    };
    Ok(sheet.table().map_err(Failure::from)?)
}

/// Predicts MTF and luminance, as `fit predict --json` does.
///
/// # Errors
/// Returns [`Refused`] if the words cannot be used, or if the table lacks a direction.
pub fn predict(words: &[OsString], result: &ResultFile, table: &Table) -> Result<String, Refused> {
    Ok(predict::predicted(&parsed(words)?, result, table)?.json(result))
}

/// Renders the mid-air image of a picture, as `fit render` does, and returns it with its facts as
/// JSON.
///
/// `camera` takes the place of the file of `--camera`, and `tables` that of `--table`.
///
/// # Errors
/// Returns [`Refused`] if the words cannot be used, the picture has a value that is not finite, a
/// table is not one of the fitted cell, or it lacks a direction.
pub fn render(
    words: &[OsString],
    result: &ResultFile,
    camera: Option<&ResultFile>,
    tables: &[&Table],
    source: InMemory,
) -> Result<(Picture, String), Refused> {
    let arguments: render::Arguments = parsed(words)?;
    let source = source
        .into_picture(arguments.transfer)
        .map_err(Failure::from)?;
    let tables = render::SeenTables::new(result, tables.iter().copied())?;
    let sheet = Fitted::new(result, tables.own()).map_err(Failure::from)?;
    let pool = terminal::pool(arguments.threads).map_err(Failure::from)?;
    let wanted = arguments.wanted(&sheet, source.width, camera)?;
    let made = pool.install(|| wanted.image(&sheet, tables.colours(), &source, SILENT));
    let (image, mut facts) = made.map_err(Failure::from)?;
    facts.lit_by(arguments.light.luminance);
    Ok((image, output::json(&facts)))
}

/// Makes a page with sliders, as `fit explore` does, and returns it with its facts as JSON.
///
/// # Errors
/// Returns [`Refused`] if the words cannot be used, if the picture has a value that is not finite,
/// or if the table is not one of the fitted cell.
pub fn explore(
    words: &[OsString],
    result: &ResultFile,
    table: &Table,
    source: Option<InMemory>,
) -> Result<(String, String), Refused> {
    let arguments: explore::Arguments = parsed(words)?;
    let picture = source.map(|held| held.into_picture(arguments.transfer));
    let picture = picture.transpose().map_err(Failure::from)?;
    let source = picture.as_ref().map(|own| (Path::new("picture"), own));
    let table = result.seen(table).map_err(Failure::from)?;
    let sheet = Fitted::new(result, &table).map_err(Failure::from)?;
    let title = "estimate in Python".into();
    let made = explore::made(&arguments, sheet, title, source, SILENT)?;
    Ok((made.html, output::json(&made.facts)))
}

/// Plan of photographs.
pub struct Photographs {
    /// The plan, as JSON.
    pub json: String,
    /// Manifest to fill in.
    pub manifest: String,
    /// Page to print.
    pub page: String,
    /// Warnings about the result that the plan builds on.
    pub warnings: Vec<String>,
}

/// Plans photographs, as `fit plan` does.
///
/// `given` takes the place of the file of `--given`, and `table` that of `--table`.
///
/// # Errors
/// Returns [`Refused`] if the words, the plan, the table or the result cannot be used.
pub fn plan(
    words: &[OsString],
    table: &Table,
    given: Option<&ResultFile>,
) -> Result<Photographs, Refused> {
    let made = plan::made(&parsed(words)?, table, given)?;
    Ok(Photographs {
        json: output::json(&made.planned),
        page: made.page("midair.plan"),
        manifest: made.manifest,
        warnings: made.warnings,
    })
}

/// Writes a synthetic campaign, as `fit simulate --json` does.
///
/// # Errors
/// Returns [`Refused`] if the words, the parameters or the table cannot be used, or if the folder
/// cannot be written.
pub fn simulate(words: &[OsString]) -> Result<String, Refused> {
    Ok(simulate::json(&simulate::written(&parsed(words)?)?))
}

/// Studies how good estimates are, as `fit study --json` does.
///
/// # Errors
/// Returns [`Refused`] if an input cannot be used, if an estimate of given photographs fails, or if
/// the caller stopped the study.
pub fn study(words: &[OsString], caller: Caller) -> Result<String, Refused> {
    Ok(study::text(&parsed(words)?, Host::Caller(caller))?)
}
