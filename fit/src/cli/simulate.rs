//! `fit simulate`: a synthetic campaign with a planted answer.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use tables::cli as terminal;

use crate::cli::failure::Failure;
use crate::simulate::Params;
use crate::simulate::write;

/// Writes a synthetic campaign: photographs with noise, captures.toml and truth.json.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The photographs are made in the spatial domain, from the closed form of the ideal cube: \
independent of the \
estimator's transforms and of any table.

Example (PARAMS.toml):
  seed = 7
  [truth]
  kernel = \"eq1\"
  lobe = \"radial\"
  ior = 1.49
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

With kernel = \"wave\" [truth] takes wavelength_nm (550, or \"450:0.2,550:0.5,620:0.3\") instead \
of lobe and a.

With --table the sheet is the one that an exact table describes, with the spots of cubes that are \
not ideal: polygons and deviations come from there, all else is as above.

  fit simulate params.toml -o campaign
  fit simulate params.toml --table pair.h5 -o of-the-table
  fit estimate campaign/captures.toml --table pair.h5 --truth campaign/truth.json")]
pub(crate) struct Arguments {
    /// Camera, sheet and captures
    pub params: PathBuf,
    /// The folder to write; created
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Exact table of the sheet to photograph, in the place of the ideal cube
    #[arg(long, value_name = "TABLE.h5")]
    pub table: Option<PathBuf>,
    /// Write into a folder that already holds something
    #[arg(long)]
    pub force: bool,
    /// Report as one JSON object
    #[arg(long)]
    pub json: bool,
    /// Threads; one per core if left out
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZeroUsize>,
}

/// Runs the verb.
///
/// # Errors
/// The parameters, or the folder.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut params = Params::load(&arguments.params)?;
    if let Some(table) = &arguments.table {
        params = params.of_sheet(&tables::read(table)?)?;
    }
    let report = terminal::pool(arguments.threads)?
        .install(|| write::run(&params, &arguments.output, arguments.force))?;
    terminal::warn(&report.warnings);
    Ok(terminal::print(&if arguments.json {
        let object = serde_json::json!({
            "manifest": report.manifest,
            "photographs": report.photographs,
            "clipped_pixels": report.clipped,
            "warnings": report.warnings,
        });
        format!("{object:#}\n")
    } else {
        format!(
            "{} photographs, manifest {}\n",
            report.photographs,
            report.manifest.display()
        )
    })?)
}
