//! `fit simulate`: writes a synthetic campaign with a planted answer.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use tables::cli as terminal;

use crate::cli::failure::Failure;
use lab::simulate::Params;
use lab::simulate::write::{self, Report};

/// Writes a synthetic campaign: noisy photographs, captures.toml and truth.json.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The photographs are made in the spatial domain, from the closed form of the
ideal cube. They use neither the transforms of the estimator nor a table.

Example (PARAMS.toml):
  seed = 7
  [truth]
  kernel = \"eq1\"
  lobe = \"radial\"
  refractive_index = 1.49
  pair = true
  a = { \"0\" = 4.9, \"20\" = 3.75 }    # or one number
  c = 0.24
  mu = 0.5
  [[capture]]
  floating_distance_mm = 150.0
  incidence_deg = 20.0
  azimuth_deg = 30.0
  edge_normal_deg = 5.0
  exposure = 6.0

[truth] may hold angular_spread_mrad: the standard deviation of the direction of the
returned light, across the plane of incidence and outside of the sheet.

If kernel is \"wave\", [truth] takes wavelength_nm in place of lobe and a. Write
550, or \"450:0.2,550:0.5,620:0.3\".

Keys that may be left out, with the values that they then have:
  [camera]
  width = 320                       # pixels
  height = 256                      # pixels
  pixel_pitch_mm = 0.05             # in the plane of the image
  seen_in_mirror = false            # true if the half mirror shows the sheet
  sigma_px = 0.55                   # blur of the lens, standard deviation
  sigma_down_px                     # along y, if it is another than along x
  pupil_cutoff_per_px               # a perfect lens instead: where its OTF ends
  halo_share = 0                    # share of the light in a halo
  halo_px = 20                      # length of its exponential line spread
  sharpening = 0                    # of pixels against the mean of 3 x 3
  source_level = 0.9                # bright side of the source at exposure 1
  half_mirror_transmittance = 0.5
  half_mirror_reflectance = 0.5
  veil = 0.004                      # light that is added everywhere
  dark_ratio = 0.01                 # dark side of the source / bright side
  full_well_e = 40000               # electrons at full scale, which is level 1
  read_noise_e = 3                  # electrons, standard deviation
  bits = 14
  hot_share = 0                     # share of pixels that are at full scale
  jpeg_quality                      # 1 to 100: 8-bit sRGB JPEG instead of EXR
  [reference]
  edge_normal_deg = 4               # from dark to bright: 0 right, 90 down
  offset_px = 0                     # of the edge, from the centre to the left
  exposure = 1
  light_to_right = 0                # gain of light from centre to right border
  light_to_bottom = 0               # gain of light from centre to lower border
  vignetting = 0                    # fall of light from centre to corners
  bow_px = 0                        # height of the arc that the edge follows
  ripple_px = 0                     # amplitude of a wave of the edge
The keys of [reference] exist in [[capture]] too; edge_normal_deg is then 5 and
exposure 6. [[capture]] further takes azimuth_deg (0), tangential_axis_deg (0)
and path_mm.

With --table, the sheet is the one that an exact table describes. The table
gives polygons and deviations, so the cubes need not be ideal.

  fit simulate params.toml -o campaign
  fit simulate params.toml --table pair.h5 -o of-the-table
  fit estimate campaign/captures.toml --table pair.h5 --truth campaign/truth.json

Words and formulas: fit/doc/model.md")]
pub(crate) struct Arguments {
    /// Parameters of the campaign: camera, sheet and captures, as TOML.
    pub params: PathBuf,
    /// Folder that is made and receives the campaign.
    ///
    /// The manifest captures.toml comes last: a folder that has one is whole, even if the program
    /// was killed.
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Exact table of the sheet, in place of the ideal cube.
    #[arg(long, value_name = "TABLE.h5")]
    pub table: Option<PathBuf>,
    /// Writes even if the folder already holds something.
    #[arg(long)]
    pub force: bool,
    /// Prints one JSON object in place of a line of text.
    #[arg(long)]
    pub json: bool,
    /// Number of threads; one per core if left out.
    #[arg(long, value_name = "N", value_parser = terminal::whole::<NonZeroUsize>(1..))]
    pub threads: Option<NonZeroUsize>,
}

/// Runs the verb.
///
/// # Errors
/// Fails if the parameters or the table cannot be used, or if the folder cannot be written.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let report = written(arguments)?;
    terminal::warn(&report.warnings);
    Ok(terminal::print(&if arguments.json {
        json(&report)
    } else {
        format!(
            "{} photographs, manifest {}\n",
            report.photographs,
            report.manifest.display()
        )
    })?)
}

/// Writes the campaign, and returns what was written.
///
/// # Errors
/// Fails as [`run`] does.
pub(in crate::cli) fn written(arguments: &Arguments) -> Result<Report, Failure> {
    let mut params = Params::load(&arguments.params)?;
    if let Some(table) = &arguments.table {
        params = params.of_sheet(&tables::read(table)?)?;
    }
    let pool = terminal::pool(arguments.threads)?;
    Ok(pool.install(|| write::run(&params, &arguments.output, arguments.force))?)
}

/// Returns what was written as JSON.
pub(in crate::cli) fn json(report: &Report) -> String {
    let object = serde_json::json!({
        "manifest": report.manifest,
        "photographs": report.photographs,
        "clipped_pixels": report.clipped,
        "warnings": report.warnings,
    });
    format!("{object:#}\n")
}
