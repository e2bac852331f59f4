//! `fit export`: the nearest retroreflective lobe as a material for renderers, or the sheet itself
//! for Mitsuba.

use std::path::PathBuf;
use tables::cli as terminal;

use tables::Outputs;

use crate::cli::estimate::read_result;
use crate::cli::failure::Failure;
use crate::cli::options::parse;
use estimator::predict::{Viewpoint, remarks};
use pictures::export::{Form, LOST, mitsuba, nearest};

/// Form of the output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Target {
    /// open_pbr_surface with specular_retroreflectivity (OpenPBR 1.2, draft), as MaterialX
    Openpbr,
    /// generalized_schlick_bsdf with retroreflective (MaterialX 1.39.5)
    Materialx,
    /// KHR_materials_retroreflection (draft)
    Gltf,
    /// midair_sheet of the Python module midair.mitsuba, with the ray shift: a scene in XML
    Mitsuba,
}

/// Writes a fitted sheet for renderers: the nearest lobe, or for Mitsuba the sheet itself.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Openpbr, materialx and gltf share one model: the minimal retroreflective
microfacet model with GGX. Its roughness is the one whose MTF differs least
(least squares) from the MTF of the sheet at the given distance and incidence.
The material has no ray shift. The scene for Mitsuba has it: it names the result
and the table, and other scenes include it.

Examples:
  fit export result.json --table pair.h5 --to materialx --distance 150 -o sheet.mtlx
  fit export result.json --table pair.h5 --to gltf --distance 300 \\
      --incidence 20 -o sheet.gltf
  fit export result.json --table pair.h5 --to mitsuba --distance 300 -o sheet.xml

Words and formulas: fit/doc/model.md")]
pub(crate) struct Arguments {
    /// Result that `fit estimate -o` wrote, as JSON.
    pub result: PathBuf,
    /// Ray-shift table of the fitted cell, from `bake trace`.
    #[arg(long, value_name = "TABLE.h5")]
    pub table: PathBuf,
    /// Form of the material.
    #[arg(long, value_enum)]
    pub to: Target,
    /// Floating distance at which the lobe is nearest, mm; for mitsuba, R of the kernels eq1 and
    /// lobe.
    #[arg(
        long,
        visible_alias = "floating-distance",
        value_name = "MM",
        value_parser = parse::positive
    )]
    pub distance: f64,
    /// Incidence at which the lobe is nearest, degrees; 0 if left out.
    #[arg(long, value_name = "DEG", value_parser = parse::incidence)]
    pub incidence: Option<f64>,
    /// Azimuth of the light at which it is nearest, degrees; that of the table if it holds one.
    #[arg(long, value_name = "DEG", value_parser = parse::turn,
        allow_negative_numbers = true)]
    pub azimuth: Option<f64>,
    /// File that receives the material, in place of standard output.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Runs the verb.
///
/// # Errors
/// Fails if the result or the table cannot be used, if the table lacks the direction, or if the
/// output cannot be written.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let place = arguments.incidence.or(arguments.azimuth);
    if arguments.to == Target::Mitsuba && place.is_some() {
        return Err(Failure::conflict(
            "fit export",
            "--to mitsuba is the sheet at all angles; leave out --incidence and --azimuth",
        ));
    }
    let mut outputs = Outputs::beside([arguments.result.as_path(), &arguments.table]);
    let output = terminal::reserve(arguments.output.as_deref(), &mut outputs)?;
    let result = read_result(&arguments.result)?;
    let table = tables::read(&arguments.table)?;
    let table = result.seen(&table)?;
    let form = match arguments.to {
        Target::Openpbr => Form::Openpbr,
        Target::Materialx => Form::Materialx,
        Target::Gltf => Form::Gltf,
        Target::Mitsuba => {
            let files = [arguments.result.as_path(), &arguments.table];
            let text = mitsuba(&result, &table, files, arguments.distance)?;
            return Ok(terminal::deliver(&text, output)?);
        }
    };
    let azimuth = arguments.azimuth.or(parse::only_azimuth(&table));
    let incidence_deg = arguments.incidence.unwrap_or(0.0);
    let lobe = nearest(&result, &table, arguments.distance, incidence_deg, azimuth)?;
    let place = Viewpoint {
        incidence_deg,
        azimuth_deg: azimuth.filter(|_| !table.axes.is_mean()),
        r_mm: arguments.distance,
    };
    terminal::warn(remarks(&result, &table, &[place])?);
    terminal::warn(form.draft().map(String::from));
    terminal::warn([format!("{LOST}. {}", lobe.criterion())]);
    Ok(terminal::deliver(&lobe.text(form), output)?)
}
