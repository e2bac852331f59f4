//! `fit estimate`: a, c and mu from a campaign of photographs.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Instant;
use tables::cli as terminal;

use tables::{Outputs, Table};

use crate::cli::failure::Failure;
use crate::cli::output;
use crate::cli::parse;
use crate::cli::sampled;
use crate::cli::sampled::Samples;
use crate::cli::terms::Terms;
use crate::estimate::Bound;
use crate::estimate::Forward;
use crate::estimate::Kind;
use crate::estimate::Watch;
use crate::estimate::campaign::campaign;
use crate::estimate::error;
use crate::estimate::{Estimated, Options};
use crate::names::Family;
use crate::names::Spectrum;
use crate::names::{ParameterId, ParameterKind};
use crate::photographs::captures;
use crate::photographs::photo::channel::Channel;
use crate::photographs::{Campaign, Shot};
#[cfg(feature = "report")]
use crate::report::page::evidence::Evidence;
#[cfg(feature = "report")]
use crate::report::page::shown::Page;
#[cfg(feature = "report")]
use crate::report::plot;
use crate::result::TableResult;
use crate::result::{Number, Parameter, ResultFile};
use crate::simulate::Truth;

/// Estimates a, c and mu of a sheet from photographs of mid-air edges.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
What is minimised: edge, by default, comes within a few percent of the Cramer-Rao bound; mtf, the \
published loss, has \
standard errors 1.7 times (c) and 2.4 times (a) the bound (`fit study`, fit/BENCHMARKS.md), its \
differences weighed by \
their noise; mse weighs all frequencies alike, as published (terms and bounds are then those of \
mtf), with errors of up to twice those of mtf.
What is left open (auto) is decided by Bayes' criterion on the residuals in units of their noise; \
a further term must \
lower it by more than 4. Standard errors carry pixel noise, the lens fit, the reference's step \
and the table's rays.

Examples:
  bake trace pair.obj -o pair.h5 --refractive-index 1.49 --incidence 0:45:5 --azimuth 30
  fit estimate captures.toml --table pair.h5 -o result.json
  fit estimate captures.toml --table pair.h5 --kernel eq1 --lobe radial --per-angle a,mu --plot \
  mtf.svg -o result.json
  fit estimate captures.toml --table pair.h5 -o result.json --report report.html
  fit estimate captures.toml --table pair.h5 --model saito -o saito.json
  bake trace pair.obj -o all.h5 --refractive-index 1.49 --azimuth full --direction-tolerance 0.005
  fit estimate captures.toml --table all.h5 --fit-azimuth
  fit estimate captures.toml --table pair.h5 --forward render --loss mse --samples 16 -o \
  result.json")]
pub(crate) struct Arguments {
    /// The campaign's manifest
    pub captures: PathBuf,
    /// The sheet's ray-shift table, made by `bake trace`
    #[arg(long, value_name = "TABLE.h5")]
    pub table: PathBuf,
    /// Write the result there (JSON)
    #[arg(short, long, value_name = "RESULT.json")]
    pub output: Option<PathBuf>,
    /// What the photographs may need.
    #[command(flatten)]
    pub terms: Terms,
    /// Wavelengths of the source and their weights, nm: 550, or 450:0.2,550:0.5,620:0.3; instead of
    /// wavelength_nm in the manifest
    #[arg(long, value_name = "NM[:WEIGHT],...", value_parser = Spectrum::parse)]
    pub wavelength_nm: Option<Spectrum>,
    /// How the model is evaluated
    #[arg(long, value_enum, default_value_t = Forward::Spectral)]
    pub forward: Forward,
    /// The samples of a render.
    #[command(flatten)]
    pub samples: Samples,
    /// What is minimised; edge if left out; mtf with --forward render, which compares MTFs
    #[arg(long, value_enum)]
    pub loss: Option<Kind>,
    /// Finds the sheet's azimuth too: one angle, added to azimuth_deg of all captures (0 where left
    /// out); needs a table of all azimuths
    #[arg(long, conflicts_with_all = ["forward", "model"])]
    pub fit_azimuth: bool,
    /// A planted answer (truth.json of `fit simulate`): printed beside the estimate
    #[arg(long, value_name = "TRUTH.json")]
    pub truth: Option<PathBuf>,
    /// Measured and modelled MTF curves as a picture, .svg or .png
    #[cfg(feature = "report")]
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// A page for a person, in one file: estimates with intervals, curves, the choice of terms,
    /// warnings with pictures
    #[cfg(feature = "report")]
    #[arg(long, value_name = "REPORT.html")]
    pub report: Option<PathBuf>,
    /// Colour channel of all photographs, whatever the manifest says: luminance, red, green, blue,
    /// a channel's name, or each: red, green and blue are fitted one by one, and the result is an
    /// object with one result per channel
    #[arg(long, value_name = "NAME", value_parser = channels)]
    pub channel: Option<Channels>,
    /// Threads; one per core if left out
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZeroUsize>,
    /// Print the result as one JSON object instead of a table
    #[arg(long)]
    pub json: bool,
}

/// The channels that are fitted.
#[derive(Debug, Clone)]
pub(crate) struct Channels(Vec<Channel>);

fn channels(text: &str) -> Result<Channels, std::convert::Infallible> {
    Ok(Channels(match text {
        "each" => Channel::PRIMARIES.to_vec(),
        name => vec![Channel::from_name(name)],
    }))
}

/// The options of the estimate as the command line has them. Ends the program with a usage error
/// where they exclude each other.
fn options(arguments: &Arguments) -> Options {
    let mut options = Options::new(arguments.terms.candidates("fit estimate"));
    if arguments.forward == Forward::Render {
        sampled::only(&mut options.candidates, arguments.loss, "fit estimate");
        options.samples = Some(arguments.samples.sampling());
    }
    options.loss = arguments.loss;
    options.fit_azimuth = arguments.fit_azimuth;
    options.spectrum = arguments.wavelength_nm.clone();
    if let Some(Channels(channels)) = &arguments.channel
        && let [one] = &channels[..]
    {
        options.channel = Some(one.clone());
    }
    options
}

/// Channels that are fitted one by one, if there are several.
fn several(arguments: &Arguments) -> Option<&[Channel]> {
    let Channels(channels) = arguments.channel.as_ref()?;
    (channels.len() > 1).then_some(channels)
}

/// Runs the verb.
///
/// # Errors
/// Manifest, photographs, table or outputs.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let options = options(arguments);
    #[cfg(feature = "report")]
    if several(arguments).is_some() && (arguments.plot.is_some() || arguments.report.is_some()) {
        clap::Command::new("fit estimate")
            .error(
                clap::error::ErrorKind::ArgumentConflict,
                "--plot and --report show one fit; name one --channel for them",
            )
            .exit();
    }
    let start = Instant::now();
    let campaign = captures::load(&arguments.captures)?;
    let mut outputs = Outputs::beside(inputs(arguments, &campaign));
    let output = terminal::reserve(arguments.output.as_deref(), &mut outputs)?;
    #[cfg(feature = "report")]
    let picture = terminal::reserve_plot(arguments.plot.as_deref(), &mut outputs)?;
    #[cfg(feature = "report")]
    let page = terminal::reserve(arguments.report.as_deref(), &mut outputs)?;
    let truth: Option<Truth> = arguments
        .truth
        .as_deref()
        .map(|path| parse::read_json(path, "holds a planted answer"))
        .transpose()?;
    let pool = terminal::pool(arguments.threads)?;
    let table = pool.install(|| tables::read(&arguments.table))?;
    let job = Job {
        arguments,
        campaign: &campaign,
        table: &table,
    };
    if let Some(channels) = several(arguments) {
        let results = pool.install(|| job.each_channel(&options, channels))?;
        let json = output::json(&results);
        if let Some(output) = output {
            output.commit(json.as_bytes())?;
        }
        let tables = results
            .iter()
            .map(|(channel, result)| format!("{channel}\n{}", summary(result, truth.as_ref())));
        return Ok(terminal::print(&if arguments.json {
            json
        } else {
            tables.collect::<Vec<_>>().join("\n")
        })?);
    }
    #[cfg_attr(
        not(feature = "report"),
        expect(unused_variables, reason = "the page shows it")
    )]
    let (estimated, result) = pool.install(|| job.run(&options, start))?;
    warn(&result, "");
    let json = output::json(&result);
    #[cfg(feature = "report")]
    if let Some((path, output)) = picture {
        output.commit(&plot::fitted(&result, path)?)?;
    }
    #[cfg(feature = "report")]
    if let Some(page) = page {
        let evidence = pool.install(|| Evidence::of(&estimated));
        let shown = Page {
            result: &result,
            campaign: &estimated.campaign,
            truth: truth.as_ref(),
            evidence: &evidence,
            command: &output::command_line(std::env::args_os()),
        };
        page.commit(pool.install(|| shown.html()).as_bytes())?;
    }
    if let Some(output) = output {
        output.commit(json.as_bytes())?;
    }
    Ok(terminal::print(&if arguments.json {
        json
    } else {
        summary(&result, truth.as_ref())
    })?)
}

/// Files that are read, of which none may be an output.
fn inputs<'a>(arguments: &'a Arguments, campaign: &'a Campaign) -> impl Iterator<Item = &'a Path> {
    let captures = campaign.captures.iter().map(|capture| &capture.shot);
    let shots = campaign.reference.iter().chain(captures);
    [arguments.captures.as_path(), &arguments.table]
        .into_iter()
        .chain(arguments.truth.as_deref())
        .chain(shots.map(|shot| shot.image.as_path()))
}

/// What is estimated from.
struct Job<'a> {
    arguments: &'a Arguments,
    campaign: &'a Campaign,
    table: &'a Table,
}

impl Job<'_> {
    /// One estimate, and what is written of it.
    fn run(&self, options: &Options, start: Instant) -> Result<(Estimated, ResultFile), Failure> {
        let (table, watch) = (self.table, &Watch::NOBODY);
        let estimated = campaign(self.campaign, &Shot::load, table, options, watch).map_err(
            |error| match error {
                error::Error::OneAzimuth { held } => Failure::OneAzimuth {
                    table: self.arguments.table.clone(),
                    held,
                },
                error => error.into(),
            },
        )?;
        let table = TableResult::of(table);
        let seconds = start.elapsed().as_secs_f64();
        let result = ResultFile::new(&estimated, table, seconds);
        Ok((estimated, result))
    }

    /// One estimate for each channel, by its name.
    fn each_channel(
        &self,
        options: &Options,
        channels: &[Channel],
    ) -> Result<BTreeMap<String, ResultFile>, Failure> {
        let one = |channel: &Channel| {
            let options = Options {
                channel: Some(channel.clone()),
                ..options.clone()
            };
            let (_, result) = self.run(&options, Instant::now())?;
            warn(&result, &format!("{channel}: "));
            Ok((channel.to_string(), result))
        };
        channels.iter().map(one).collect()
    }
}

/// Says what the user should know of a result.
fn warn(result: &ResultFile, before: &str) {
    for warning in &result.warnings {
        terminal::warn([format!("{before}{warning}")]);
    }
    for capture in &result.captures {
        for warning in &capture.warnings {
            terminal::warn([format!("{before}{}: {warning}", capture.image)]);
        }
    }
}

/// The result as a table for a person.
fn summary(result: &ResultFile, truth: Option<&Truth>) -> String {
    let mut text = head(result);
    let beside = if truth.is_some() {
        "truth     difference"
    } else {
        ""
    };
    let _ = writeln!(
        text,
        "{:<12}{:>10}{:>12}{:>14}   {beside}",
        "", "incidence", "estimate", "std. error"
    );
    let mut rows = Rows { text, truth };
    let sizes = [result.c_mm, result.surface_roughness].map(|size| size.map(Parameter::Shared));
    let azimuth = result.azimuth_deg.map(Parameter::Shared);
    // Roughnesses are thousandths, and shown as such.
    let parameters = [
        ("c (mm)", ParameterKind::CornerSize, 1.0, &sizes[0]),
        (
            "1000 x front",
            ParameterKind::SurfaceRoughness,
            1e3,
            &sizes[1],
        ),
        (
            "1000 x rough",
            ParameterKind::Roughness,
            1e3,
            &result.roughness,
        ),
        ("a (1/mm)", ParameterKind::APerMm, 1.0, &result.a_per_mm),
        ("a R", ParameterKind::ATimesR, 1.0, &result.a_times_r),
        ("mu", ParameterKind::Mu, 1.0, &result.mu),
        ("azimuth (°)", ParameterKind::Azimuth, 1.0, &azimuth),
    ];
    for (label, kind, scale, parameter) in parameters {
        rows.add(label, kind, scale, parameter.as_ref());
    }
    let mut text = rows.text;
    for (id, bound) in &result.bounds {
        let _ = writeln!(text, "{}", bounded(*id, *bound));
    }
    text
}

/// What was fitted, to what, and how.
fn head(result: &ResultFile) -> String {
    let lobe = result
        .lobe
        .map_or(String::new(), |l| format!(", lobe {}", l.name()));
    let samples = result.sampling.as_ref().map_or(String::new(), |own| {
        format!(", {} samples a pixel", own.sampling.samples)
    });
    format!(
        "kernel {}{lobe}, loss {}{samples}; {} photographs, table {}; {} after {} evaluations, \
        {:.2} s\n",
        result.kernel.name(),
        result.loss.name(),
        result.captures.len(),
        result.table.design,
        result.stop,
        result.iterations,
        result.seconds
    )
}

/// Rows of the table of estimates.
struct Rows<'a> {
    text: String,
    truth: Option<&'a Truth>,
}

impl Rows<'_> {
    /// A parameter, in units of 1 / `scale`.
    fn add(&mut self, label: &str, kind: ParameterKind, scale: f64, parameter: Option<&Parameter>) {
        let scaled = |value: Option<f64>, standard_error: Option<f64>| Number {
            value: value.map(|v| v * scale),
            standard_error: standard_error.map(|v| v * scale),
        };
        match parameter {
            None => {}
            Some(Parameter::Shared(n)) => {
                self.row(label, kind.shared(), scaled(n.value, n.standard_error));
            }
            Some(Parameter::PerAngle { per_angle }) => {
                for p in per_angle {
                    let number = scaled(p.value, p.standard_error);
                    self.row(label, kind.at(p.incidence_deg), number);
                }
            }
        }
    }

    fn row(&mut self, label: &str, id: ParameterId, number: Number) {
        let angle = id.incidence_deg.map_or(String::new(), |i| format!("{i}°"));
        let shown = |v: Option<f64>| v.map_or("-".to_owned(), |v| format!("{v:.5}"));
        let _ = write!(
            self.text,
            "{label:<12}{angle:>10}{:>12}{:>14}",
            shown(number.value),
            shown(number.standard_error)
        );
        let planted = |truth: &Truth| truth.of(id);
        if let (Some(truth), Some(value)) = (self.truth.and_then(planted), number.value) {
            let _ = write!(
                self.text,
                "   {truth:<8} {:>+9.3} %",
                100.0 * (value / truth - 1.0)
            );
        }
        self.text.push('\n');
    }
}

/// A bound in words.
fn bounded(id: ParameterId, bound: Bound) -> String {
    let shown = |v: f64| {
        if v < 1e-3 {
            format!("{v:.2e}")
        } else {
            format!("{v:.4}")
        }
    };
    let side = match (bound.at_least, bound.at_most) {
        (Some(v), _) => format!("> {}", shown(v)),
        (_, Some(v)) => format!("< {}", shown(v)),
        _ => "not bounded by these photographs".into(),
    };
    format!("{id} {side} (at {:.0} %)", 100.0 * bound.confidence)
}

/// Reads a RESULT.json of one fit.
///
/// # Errors
/// [`Failure::Json`]; [`Failure::Channel`] for one of several channels.
pub(crate) fn read_result(path: &Path) -> Result<ResultFile, Failure> {
    read_channel(path, None)
}

/// That a result is of the model that was named, if one was.
///
/// # Errors
/// [`Failure::Model`].
pub(crate) fn check_model(
    path: &Path,
    result: &ResultFile,
    model: Option<Family>,
) -> Result<(), Failure> {
    match model {
        Some(asked) if asked != result.model => Err(Failure::Model {
            path: path.to_owned(),
            asked,
        }),
        _ => Ok(()),
    }
}

/// Reads a RESULT.json of one fit, or, by its name, one channel of a file of several.
///
/// # Errors
/// [`Failure::Json`]; [`Failure::Channel`] where the file holds several and none of them is named,
/// or another.
pub(crate) fn read_channel(path: &Path, channel: Option<&str>) -> Result<ResultFile, Failure> {
    let expected = "`fit estimate -o` wrote";
    let several = || parse::read_json::<BTreeMap<String, ResultFile>>(path, expected);
    let channels = |held: BTreeMap<String, ResultFile>| Failure::Channel {
        path: path.to_owned(),
        held: held.into_keys().collect::<Vec<_>>().join(", "),
    };
    match channel {
        None => {
            parse::read_json(path, expected).map_err(|failure| several().map_or(failure, channels))
        }
        Some(name) => {
            let mut held = several()?;
            held.remove(name).ok_or_else(|| channels(held))
        }
    }
}
