//! `fit export`: the nearest retroreflective lobe for renderers.

use std::path::PathBuf;
use tables::cli as terminal;

use tables::Outputs;

use crate::cli::estimate::read_result;
use crate::cli::failure::Failure;
use crate::cli::parse;
use crate::predict::{Form, LOST, nearest};

/// Writes the nearest lobe of a fitted sheet as a material for renderers.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The lobe is that of the minimal retroreflective microfacet model with GGX, which the three forms \
share; its roughness has the \
least squared MTF difference from the sheet at the distance and incidence given. Ray shift is not \
carried.

Examples:
  fit export result.json --table pair.h5 --to materialx --distance 150 -o sheet.mtlx
  fit export result.json --table pair.h5 --to gltf --distance 300 --incidence 20 -o sheet.gltf")]
pub(crate) struct Arguments {
    /// What `fit estimate -o` wrote
    pub result: PathBuf,
    /// A table of the fitted cell
    #[arg(long, value_name = "TABLE.h5")]
    pub table: PathBuf,
    /// Form of the material
    #[arg(long, value_enum)]
    pub to: Form,
    /// Floating distance at which the lobe is nearest, mm
    #[arg(long, value_name = "MM", value_parser = parse::positive)]
    pub distance: f64,
    /// Incidence at which it is, degrees
    #[arg(long, value_name = "DEG", default_value = "0", value_parser = parse::incidence)]
    pub incidence: f64,
    /// Azimuth, degrees; the table's own if it holds only one
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub azimuth: Option<f64>,
    /// Write there instead of standard output
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Runs the verb.
///
/// # Errors
/// Result, table, direction or output.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut outputs = Outputs::beside([arguments.result.as_path(), &arguments.table]);
    let output = terminal::reserve(arguments.output.as_deref(), &mut outputs)?;
    let result = read_result(&arguments.result)?;
    let table = tables::read(&arguments.table)?;
    let azimuth = arguments.azimuth.or(parse::only_azimuth(&table));
    let lobe = nearest(
        &result,
        &table,
        arguments.distance,
        arguments.incidence,
        azimuth,
    )?;
    terminal::warn([format!("{LOST}. {}", lobe.criterion())]);
    Ok(terminal::deliver(&lobe.text(arguments.to), output)?)
}
