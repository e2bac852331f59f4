//! The command line of `fit estimate`.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Duration;

use tables::cli as terminal;

use crate::cli::failure::Failure;
use crate::cli::options::sampled;
use crate::cli::options::sampled::Samples;
use crate::cli::options::terms::Terms;
use edges::names::Spectrum;
use edges::photographs::photo::channel::Channel;
use estimator::estimate::Forward;
use estimator::estimate::Kind;
use estimator::estimate::Options;

/// Estimates a, c and mu of a sheet from photographs of mid-air edges.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Losses (--loss):
  edge  compares the pixels around the edge by maximum likelihood. Its errors
        are within a few percent of the Cramer-Rao bound.
  mtf   compares the MTF curves, each difference weighted by its noise. Its
        errors are 1.7 (c) and 2.4 (a) times the bound.
  mse   compares the MTF curves, all frequencies alike, as in the paper. Its
        errors are up to twice those of mtf. Terms and bounds are those of mtf.
`fit study` and fit/BENCHMARKS.md give these figures.

Terms that you leave open (auto) are chosen by Bayes' information criterion
(BIC) on the residuals in units of their noise: a further term must lower it by
more than 4. Standard errors contain the noise of the pixels, the fit of the
lens, the step of the reference and the noise of the table's rays.

The manifest's key seen_in_mirror (false if left out) says whether the camera
sees the sheet in the half mirror or straight. If the answer depends on it and
it is left out, a warning names both answers.

Examples:
  bake trace pair.obj -o pair.h5 --refractive-index 1.49 --incidence 0:45:5 \\
      --azimuth 30
  fit estimate captures.toml --table pair.h5 -o result.json
  fit estimate captures.toml --table pair.h5 --kernel eq1 --lobe radial \\
      --per-angle a,mu --plot mtf.svg -o result.json
  fit estimate captures.toml --table pair.h5 -o result.json --report report.html
  fit estimate captures.toml --table pair.h5 --model saito --loss mtf \\
      -o saito.json
  bake trace pair.obj -o all.h5 --refractive-index 1.49 --azimuth full \\
      --direction-tolerance 0.005
  fit estimate captures.toml --table all.h5 --fit-azimuth
  fit estimate captures.toml --table pair.h5 --forward render --loss mse \\
      --samples 16 -o result.json

Words and formulas: fit/doc/model.md")]
pub(crate) struct Arguments {
    /// Manifest of the campaign (captures.toml), which lists the photographs.
    pub captures: PathBuf,
    /// Ray-shift table of the sheet, from `bake trace`.
    ///
    /// It may be given several times. The further tables are tried if the first one does not
    /// describe the photographs.
    #[arg(long, value_name = "TABLE.h5", required = true)]
    pub table: Vec<PathBuf>,
    /// Content hash that the table must have, as `bake verify` prints it.
    ///
    /// Of several tables it is that of the first one. The key expect_table in [setup] of the
    /// manifest does the same. If both are given, they must agree.
    #[arg(long, value_name = "HASH")]
    pub expect_table: Option<String>,
    /// File that receives the result, as JSON.
    #[arg(short, long, value_name = "RESULT.json")]
    pub output: Option<PathBuf>,
    /// Terms of the model.
    #[command(flatten)]
    pub terms: Terms,
    /// Wavelengths of the source, nm, with their weights.
    ///
    /// Write 550, or 450:0.2,550:0.5,620:0.3. The wavelengths replace wavelength_nm of the
    /// manifest. Only the kernel wave needs them.
    #[arg(
        long,
        value_name = "NM[:WEIGHT],...",
        value_parser = Spectrum::parse,
        help_heading = "Light"
    )]
    pub wavelength_nm: Option<Spectrum>,
    /// Forward model.
    ///
    /// spectral evaluates the model in closed form. render draws samples, as the published loop
    /// does, and reports its sampling error.
    #[arg(
        long,
        value_enum,
        default_value_t = Forward::Spectral,
        help_heading = "Forward model"
    )]
    pub forward: Forward,
    /// Samples of a render.
    #[command(flatten)]
    pub samples: Samples,
    /// Loss to minimise; edge if left out.
    ///
    /// With --forward render it is mtf if left out, because a render is compared by its MTF. The
    /// losses are described below.
    #[arg(long, value_enum, help_heading = "Forward model")]
    pub loss: Option<Kind>,
    /// Estimates the azimuth of the sheet too, in degrees.
    ///
    /// One angle is estimated. It is added to azimuth_deg of each capture, which is 0 if left out.
    /// The table must hold all azimuths (bake trace --azimuth full).
    #[arg(long, conflicts_with_all = ["forward", "model"], help_heading = "Model")]
    pub fit_azimuth: bool,
    /// Seconds that the search for mistakes may take if the fit is not good.
    ///
    /// It is 0 for no search. The file of the result is written before the search begins, and again
    /// after it. A search that comes to its end gives the same result each time; the key
    /// fit.diagnosis says whether it did. A trial that has begun is finished.
    #[arg(
        long,
        value_name = "SECONDS",
        default_value = "10",
        value_parser = seconds,
        help_heading = "Output and threads"
    )]
    pub diagnose: Duration,
    /// Planted answer to print beside the estimate.
    ///
    /// It is the truth.json that `fit simulate` writes.
    #[arg(long, value_name = "TRUTH.json", help_heading = "Output and threads")]
    pub truth: Option<PathBuf>,
    /// File that receives the MTF curves as a picture, .svg.
    ///
    /// The picture shows the measured and the modelled curves.
    #[cfg(feature = "full")]
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// File that receives all results on one page, as HTML.
    ///
    /// The page shows estimates with intervals, curves, the choice of terms, and warnings with
    /// pictures.
    #[cfg(feature = "full")]
    #[arg(long, value_name = "REPORT.html")]
    pub report: Option<PathBuf>,
    /// Colour channel that is fitted: a name, or each.
    ///
    /// Write luminance, red, green, blue, or the name of a channel in the file. The channel
    /// replaces that of the manifest, for all photographs. With each, red, green and blue are
    /// fitted one by one, and the result is an object with one result per channel.
    #[arg(long, value_name = "NAME", value_parser = channels, help_heading = "Light")]
    pub channel: Option<Channels>,
    /// Number of threads; one per core if left out.
    #[arg(
        long,
        value_name = "N",
        help_heading = "Output and threads",
        value_parser = terminal::whole::<NonZeroUsize>(1..)
    )]
    pub threads: Option<NonZeroUsize>,
    /// Prints the result as one JSON object in place of a table.
    #[arg(long, help_heading = "Output and threads")]
    pub json: bool,
}

/// Channels that are fitted.
#[derive(Debug, Clone)]
pub(crate) struct Channels(Vec<Channel>);

fn channels(text: &str) -> Result<Channels, std::convert::Infallible> {
    Ok(Channels(match text {
        "each" => Channel::PRIMARIES.to_vec(),
        name => vec![Channel::from_name(name)],
    }))
}

/// Reads a number of seconds, at least 0.
fn seconds(text: &str) -> Result<Duration, String> {
    let number = terminal::number(text)?;
    Duration::try_from_secs_f64(number)
        .map_err(|_| "must be a number of seconds from 0 to 1.8e19".to_owned())
}

/// Returns the options of the estimate that the command line gives.
///
/// # Errors
/// Returns [`Failure::Usage`] if they exclude each other.
pub(super) fn options(arguments: &Arguments) -> Result<Options, Failure> {
    let mut options = Options::new(arguments.terms.candidates("fit estimate")?);
    if arguments.forward == Forward::Render {
        options.candidates = sampled::only(options.candidates, arguments.loss, "fit estimate")?;
        options.samples = Some(arguments.samples.sampling());
    }
    options.loss = arguments.loss;
    options.diagnose = Some(arguments.diagnose);
    options.fit_azimuth = arguments.fit_azimuth;
    options.spectrum = arguments.wavelength_nm.clone();
    if let Some(Channels(channels)) = &arguments.channel
        && let [one] = &channels[..]
    {
        options.channel = Some(one.clone());
    }
    Ok(options)
}

impl Arguments {
    /// Returns the table that the fit uses. There is at least one.
    pub(super) fn first_table(&self) -> &Path {
        self.table.first().map_or(Path::new(""), PathBuf::as_path)
    }
}

/// Returns the channels that are fitted one by one, or `None` if there is one only.
pub(super) fn several(arguments: &Arguments) -> Option<&[Channel]> {
    let Channels(channels) = arguments.channel.as_ref()?;
    (channels.len() > 1).then_some(channels)
}
