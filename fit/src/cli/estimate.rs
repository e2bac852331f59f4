//! `fit estimate`: a, c and mu from a campaign of photographs.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Instant;

use tables::{Outputs, Table};

use crate::cli::cli;
use crate::cli::cli::Failure;
use crate::cli::sampled;
use crate::cli::sampled::Samples;
use crate::cli::terms;
use crate::cli::terms::Terms;
use crate::compare::view::Weights;
use crate::estimate::azimuth;
use crate::estimate::azimuth::Azimuth;
use crate::estimate::bound::{absent, bounds};
use crate::estimate::estimate;
use crate::estimate::estimate::{Value, refined};
use crate::estimate::forward;
use crate::estimate::forward::Forward;
use crate::estimate::loss::{Kind, Loss};
use crate::estimate::scene::Scene;
use crate::estimate::select::{Candidates, Selection, select};
use crate::model::kernel::Family;
use crate::numerics::solve::Stop;
use crate::photographs::captures;
use crate::photographs::captures::{Campaign, Spectrum};
use crate::photographs::photo::Channel;
#[cfg(feature = "report")]
use crate::report::page::{Evidence, Page};
#[cfg(feature = "report")]
use crate::report::plot;
use crate::result::report::{Number, Parameter, ResultFile, TableResult};
use crate::simulate::truth::Truth;

/// Estimates a, c and mu of a sheet from photographs of mid-air edges.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
What is minimised: edge, by default, comes within a few percent of the Cramer-Rao bound; mtf, the published loss, has \
standard errors 1.7 times (c) and 2.4 times (a) the bound (`fit study`, fit/BENCHMARKS.md), its differences weighed by \
their noise; mse weighs all frequencies alike, as published (terms and bounds are then those of mtf), with errors of up to twice those of mtf.
What is left open (auto) is decided by Bayes' criterion on the residuals in units of their noise; a further term must \
lower it by more than 4. Standard errors carry pixel noise, the lens fit, the reference's step and the table's rays.

Examples:
  bake trace pair.obj -o pair.h5 --refractive-index 1.49 --incidence 0:45:5 --azimuth 30
  fit estimate captures.toml --table pair.h5 -o result.json
  fit estimate captures.toml --table pair.h5 --kernel eq1 --lobe radial --per-angle a,mu --plot mtf.svg -o result.json
  fit estimate captures.toml --table pair.h5 -o result.json --report report.html
  fit estimate captures.toml --table pair.h5 --model saito -o saito.json
  bake trace pair.obj -o all.h5 --refractive-index 1.49 --azimuth full --direction-tolerance 0.005
  fit estimate captures.toml --table all.h5 --fit-azimuth
  fit estimate captures.toml --table pair.h5 --forward render --loss mse --samples 16 -o result.json")]
pub struct Arguments {
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
    /// Wavelengths of the source and their weights, nm: 550, or 450:0.2,550:0.5,620:0.3; instead of wavelength_nm in
    /// the manifest
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
    /// Finds the sheet's azimuth too: one angle, added to azimuth_deg of all captures (0 where left out); needs a table of all
    /// azimuths
    #[arg(long, conflicts_with_all = ["forward", "model"])]
    pub fit_azimuth: bool,
    /// A planted answer (truth.json of `fit simulate`): printed beside the estimate
    #[arg(long, value_name = "TRUTH.json")]
    pub truth: Option<PathBuf>,
    /// Measured and modelled MTF curves as a picture, .svg or .png
    #[cfg(feature = "report")]
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// A page for a person, in one file: estimates with intervals, curves, the choice of terms, warnings with pictures
    #[cfg(feature = "report")]
    #[arg(long, value_name = "REPORT.html")]
    pub report: Option<PathBuf>,
    /// Colour channel of all photographs, whatever the manifest says: luminance, red, green, blue, a channel's name, or each:
    /// red, green and blue are fitted one by one, and the result is an object with one result per channel
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
pub struct Channels(Vec<Channel>);

fn channels(text: &str) -> Result<Channels, std::convert::Infallible> {
    Ok(Channels(match text {
        "each" => Channel::PRIMARIES.to_vec(),
        name => vec![Channel::from_name(name)],
    }))
}

/// Runs the verb.
///
/// # Errors
/// Manifest, photographs, table or outputs.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut candidates = arguments.terms.candidates("fit estimate");
    if arguments.forward == Forward::Render {
        sampled::only(&mut candidates, arguments.loss, "fit estimate");
    }
    #[cfg(feature = "report")]
    let several = |Channels(list): &Channels| list.len() > 1;
    #[cfg(feature = "report")]
    if arguments.channel.as_ref().is_some_and(several)
        && (arguments.plot.is_some() || arguments.report.is_some())
    {
        clap::Command::new("fit estimate")
            .error(
                clap::error::ErrorKind::ArgumentConflict,
                "--plot and --report show one fit; name one --channel for them",
            )
            .exit();
    }
    let start = Instant::now();
    let mut campaign = captures::load(&arguments.captures)?;
    if let Some(spectrum) = &arguments.wavelength_nm {
        campaign.setup.spectrum = Some(spectrum.clone());
    }
    if arguments.fit_azimuth {
        for capture in &mut campaign.captures {
            capture.azimuth_deg.get_or_insert(0.0);
        }
    }
    let shots = campaign
        .reference
        .iter()
        .chain(campaign.captures.iter().map(|capture| &capture.shot));
    let named = [arguments.captures.as_path(), &arguments.table];
    let inputs = named
        .into_iter()
        .chain(arguments.truth.as_deref())
        .chain(shots.map(|shot| shot.image.as_path()));
    let mut outputs = Outputs::beside(inputs);
    let output = cli::reserve(arguments.output.as_deref(), &mut outputs)?;
    #[cfg(feature = "report")]
    let picture = cli::reserve_picture(arguments.plot.as_deref(), &mut outputs)?;
    #[cfg(feature = "report")]
    let page = cli::reserve(arguments.report.as_deref(), &mut outputs)?;
    let truth: Option<Truth> = arguments
        .truth
        .as_deref()
        .map(|path| cli::read_json(path, "holds a planted answer"))
        .transpose()?;
    let pool = cli::pool(arguments.threads)?;
    if let Some(Channels(channels)) = &arguments.channel {
        if let [one] = &channels[..] {
            campaign = campaign.in_channel(one);
        } else {
            let results =
                pool.install(|| each_channel(arguments, &candidates, &campaign, channels))?;
            let json = cli::json(&results);
            if let Some(output) = output {
                output.commit(json.as_bytes())?;
            }
            let tables = results
                .iter()
                .map(|(channel, result)| format!("{channel}\n{}", summary(result, truth.as_ref())));
            return cli::print(&if arguments.json {
                json
            } else {
                tables.collect::<Vec<_>>().join("\n")
            });
        }
    }
    #[cfg_attr(
        not(feature = "report"),
        expect(unused_variables, reason = "the page shows it")
    )]
    let (result, evidence) = pool.install(|| estimate(arguments, &candidates, &campaign, start))?;
    warn(&result, "");
    let json = cli::json(&result);
    #[cfg(feature = "report")]
    if let Some((path, output)) = picture {
        output.commit(&plot::fitted(&result, path)?)?;
    }
    #[cfg(feature = "report")]
    if let (Some(page), Some(evidence)) = (page, &evidence) {
        let shown = Page {
            result: &result,
            campaign: &campaign,
            truth: truth.as_ref(),
            evidence,
            command: &cli::command_line(std::env::args_os()),
        };
        page.commit(pool.install(|| shown.html()).as_bytes())?;
    }
    if let Some(output) = output {
        output.commit(json.as_bytes())?;
    }
    cli::print(&if arguments.json {
        json
    } else {
        summary(&result, truth.as_ref())
    })
}

/// One estimate for each channel, by its name.
fn each_channel(
    arguments: &Arguments,
    candidates: &Candidates,
    campaign: &Campaign,
    channels: &[Channel],
) -> Result<BTreeMap<String, ResultFile>, Failure> {
    let one = |channel: &Channel| {
        let campaign = campaign.in_channel(channel);
        let (result, _) = estimate(arguments, candidates, &campaign, Instant::now())?;
        warn(&result, &format!("{channel}: "));
        Ok((channel.to_string(), result))
    };
    channels.iter().map(one).collect()
}

/// Says what the user should know of a result.
fn warn(result: &ResultFile, before: &str) {
    for warning in &result.warnings {
        cli::warn(&format!("{before}{warning}"));
    }
    for capture in &result.captures {
        for warning in &capture.warnings {
            cli::warn(&format!("{before}{}: {warning}", capture.image));
        }
    }
}

/// What the page shows beyond the result.
#[cfg(feature = "report")]
type Rest = Option<Evidence>;
#[cfg(not(feature = "report"))]
type Rest = ();

fn estimate(
    arguments: &Arguments,
    candidates: &Candidates,
    campaign: &Campaign,
    start: Instant,
) -> Result<(ResultFile, Rest), Failure> {
    let table = tables::read(&arguments.table)?;
    let mut scene = Scene::load(campaign, &table)?;
    let turned = arguments
        .fit_azimuth
        .then(|| turned(arguments, &mut scene, &table));
    let turned = turned.transpose()?;
    let candidates = terms::possible(candidates, &mut scene, &arguments.captures)?;
    let render = arguments.forward == Forward::Render;
    let default = if render { Kind::Mtf } else { Kind::Edge };
    let kind = arguments.loss.unwrap_or(default);
    let weights = match kind {
        Kind::Mse => Weights::Even,
        Kind::Mtf | Kind::Edge => Weights::Noise,
    };
    // Terms, and what the photographs only bound, are decided in closed form and in units of the noise.
    let telling = if kind == Kind::Mse { Kind::Mtf } else { kind };
    let mut selection = select(&scene, telling, &candidates);
    let mut bounds = bounds(&scene, &selection.loss, &selection.best);
    bounds.extend(absent(&scene, &selection));
    if render {
        let Selection { best, compared, .. } = selection;
        let sampling = arguments.samples.sampling();
        let best = forward::by_samples(&mut scene, &table, weights, best.choice, sampling)?;
        selection = Selection {
            loss: Loss::of_mtfs(&scene, weights),
            best,
            compared,
        };
    } else if kind == Kind::Mse {
        let loss = Loss::Mse(&scene);
        let best = refined(&scene, &loss, selection.best.optimum());
        selection.best = estimate::estimate(&scene, &loss, best);
        selection.loss = loss;
    }
    if let Some(found) = &turned {
        let Selection {
            mut best, compared, ..
        } = selection;
        best.add_scatter(&azimuth::scatter(
            &mut scene,
            &table,
            found,
            kind,
            best.choice,
        )?);
        let near = best.solution.parameters.clone();
        selection = Selection {
            loss: Loss::new(kind, &scene, (best.choice, &near)),
            best,
            compared,
        };
    }
    let finite = |value: &Value| value.value.is_finite();
    let best = &selection.best;
    let all = best
        .c_mm
        .iter()
        .chain(&best.spread)
        .chain(best.mu.iter().flatten());
    if best.solution.stop == Stop::Failed || !best.chi2.is_finite() || !all.into_iter().all(finite)
    {
        return Err(Failure::NoFit {
            manifest: arguments.captures.clone(),
        });
    }
    let source = TableResult::of(&table);
    let seconds = start.elapsed().as_secs_f64();
    let mut result = ResultFile::new(&scene, &selection, bounds, source, seconds);
    if let Some(found) = turned {
        result.azimuth_deg = Some(Number {
            value: Some(found.deg.value),
            standard_error: Some(found.deg.standard_error),
        });
        let others = found.others_deg.iter();
        result.warnings.extend(others.map(|deg| {
            format!("the photographs are as likely at azimuth {deg:.2} deg; an edge in another direction would tell")
        }));
    }
    #[cfg(feature = "report")]
    let evidence = arguments.report.as_ref();
    #[cfg(feature = "report")]
    let evidence = evidence.map(|_| Evidence::of(&scene, &selection, &result.bounds));
    #[cfg(not(feature = "report"))]
    let evidence = ();
    Ok((result, evidence))
}

/// The azimuth that the photographs themselves tell, the scene left there.
fn turned(arguments: &Arguments, scene: &mut Scene, table: &Table) -> Result<Azimuth, Failure> {
    let one = |held| Failure::OneAzimuth {
        table: arguments.table.clone(),
        held,
    };
    if table.axes.is_mean() {
        return Err(one("it is a mean over all"));
    }
    if table.axes.azimuth_deg.len() < 2 {
        return Err(one("it holds one"));
    }
    let choice = azimuth::flexible(scene);
    Ok(azimuth::find(scene, table, choice)?)
}

/// The result as a table for a person.
fn summary(result: &ResultFile, truth: Option<&Truth>) -> String {
    let mut text = String::new();
    let lobe = result
        .lobe
        .map_or(String::new(), |l| format!(", lobe {}", l.name()));
    let samples = result.sampling.as_ref().map_or(String::new(), |own| {
        format!(", {} samples a pixel", own.sampling.samples)
    });
    let _ = writeln!(
        text,
        "kernel {}{lobe}, loss {}{samples}; {} photographs, table {}; {} after {} evaluations, {:.2} s",
        result.kernel.name(),
        result.loss.name(),
        result.captures.len(),
        result.table.design,
        result.stop,
        result.iterations,
        result.seconds
    );
    let head = if truth.is_some() {
        "truth     difference"
    } else {
        ""
    };
    let _ = writeln!(
        text,
        "{:<12}{:>10}{:>12}{:>14}   {head}",
        "", "incidence", "estimate", "std. error"
    );
    let planted = |key: &str, incidence: Option<f64>| truth?.of(key, incidence);
    let mut row = |label: &str, key: &str, incidence: Option<f64>, number: Number| {
        let angle = incidence.map_or(String::new(), |i| format!("{i}°"));
        let shown = |v: Option<f64>| v.map_or("-".to_owned(), |v| format!("{v:.5}"));
        let _ = write!(
            text,
            "{label:<12}{angle:>10}{:>12}{:>14}",
            shown(number.value),
            shown(number.standard_error)
        );
        if let (Some(truth), Some(value)) = (planted(key, incidence), number.value) {
            let _ = write!(
                text,
                "   {truth:<8} {:>+9.3} %",
                100.0 * (value / truth - 1.0)
            );
        }
        text.push('\n');
    };
    let sizes = [result.c_mm, result.surface_roughness].map(|size| size.map(Parameter::Shared));
    // Roughnesses are thousandths, and shown as such.
    let parameters = [
        ("c (mm)", "c_mm", 1.0, &sizes[0]),
        ("1000 x front", "surface_roughness", 1e3, &sizes[1]),
        ("1000 x rough", "roughness", 1e3, &result.roughness),
        ("a (1/mm)", "a_per_mm", 1.0, &result.a_per_mm),
        ("a R", "a_times_r", 1.0, &result.a_times_r),
        ("mu", "mu", 1.0, &result.mu),
    ];
    for (label, key, scale, parameter) in parameters {
        let scaled = |value: Option<f64>, standard_error: Option<f64>| Number {
            value: value.map(|v| v * scale),
            standard_error: standard_error.map(|v| v * scale),
        };
        match parameter {
            None => {}
            Some(Parameter::Shared(n)) => row(label, key, None, scaled(n.value, n.standard_error)),
            Some(Parameter::PerAngle { per_angle }) => {
                for p in per_angle {
                    let number = scaled(p.value, p.standard_error);
                    row(label, key, Some(p.incidence_deg), number);
                }
            }
        }
    }
    if let Some(azimuth) = result.azimuth_deg {
        row("azimuth (°)", "azimuth_deg", None, azimuth);
    }
    for (name, bound) in &result.bounds {
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
        let _ = writeln!(text, "{name} {side} (at {:.0} %)", 100.0 * bound.confidence);
    }
    text
}

/// Reads a RESULT.json of one fit.
///
/// # Errors
/// [`Failure::Json`]; [`Failure::Channel`] for one of several channels.
pub fn read_result(path: &Path) -> Result<ResultFile, Failure> {
    read_channel(path, None)
}

/// That a result is of the model that was named, if one was.
///
/// # Errors
/// [`Failure::Model`].
pub fn check_model(path: &Path, result: &ResultFile, model: Option<Family>) -> Result<(), Failure> {
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
/// [`Failure::Json`]; [`Failure::Channel`] where the file holds several and none of them is named, or another.
pub fn read_channel(path: &Path, channel: Option<&str>) -> Result<ResultFile, Failure> {
    let expected = "`fit estimate -o` wrote";
    let several = || cli::read_json::<BTreeMap<String, ResultFile>>(path, expected);
    let channels = |held: BTreeMap<String, ResultFile>| Failure::Channel {
        path: path.to_owned(),
        held: held.into_keys().collect::<Vec<_>>().join(", "),
    };
    match channel {
        None => {
            cli::read_json(path, expected).map_err(|failure| several().map_or(failure, channels))
        }
        Some(name) => {
            let mut held = several()?;
            held.remove(name).ok_or_else(|| channels(held))
        }
    }
}
