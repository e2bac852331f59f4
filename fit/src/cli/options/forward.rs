//! `fit study CAPTURES --forward render`: time and error of the forward models, as a table.

use std::fmt::Write;

use tables::cli as terminal;

use crate::cli::options::parse;
use estimator::estimate::Forward;
use estimator::samples::Sampling;
use estimator::samples::Sequence;
use lab::study::Speed;

/// Renders that are studied.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct Renders {
    /// Forward model that is studied.
    ///
    /// render times estimates by samples and gives their errors against the closed form.
    #[arg(
        long,
        value_enum,
        conflicts_with = "ranges",
        help_heading = "Forward model"
    )]
    pub forward: Option<Forward>,
    /// Samples per pixel of --forward render, a list.
    #[arg(
        long,
        value_name = "LIST",
        default_value = "1,4,16,64,256",
        value_parser = samples,
        requires = "forward",
        help_heading = "Forward model"
    )]
    pub samples: Samples,
    /// Independent randomisations of each number of samples.
    ///
    /// Their scatter gives the errors.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 8,
        value_parser = terminal::whole::<u64>(2..=1000),
        requires = "forward",
        help_heading = "Forward model"
    )]
    pub randomisations: u64,
}

/// Numbers of samples per pixel.
#[derive(Debug, Clone)]
pub(crate) struct Samples(Vec<usize>);

fn samples(text: &str) -> Result<Samples, String> {
    let list = parse::positives(text)?;
    match list.iter().find(|n| n.fract() != 0.0 || **n > 65_536.0) {
        Some(bad) => Err(format!("{bad} is no whole number from 1 to 65536")),
        None => Ok(Samples(list.into_iter().map(|n| n as usize).collect())),
    }
}

impl Renders {
    /// Returns the samplings to study: each number of samples, evenly spread and independent.
    pub(crate) fn samplings(&self, seed: u64) -> Vec<Sampling> {
        let Samples(list) = &self.samples;
        [Sequence::Sobol, Sequence::Independent]
            .into_iter()
            .flat_map(|sequence| {
                list.iter().map(move |&samples| Sampling {
                    samples,
                    seed,
                    sequence,
                })
            })
            .collect()
    }
}

fn percent(value: Option<f64>) -> String {
    value.map_or("-".into(), |v| format!("{:.4}", 100.0 * v))
}

/// Returns the study as a table for a reader.
pub(crate) fn table(speed: &Speed) -> String {
    let mut text = format!(
        "{} photographs, loss mtf; closed form: {:.4} s for the estimate ({} evaluations), {:.5} \
         s for one evaluation\n\
         standard errors from the noise of the pixels: c {} %, a {} %, mu {} %\n",
        speed.photographs,
        speed.spectral_seconds,
        speed.spectral_iterations,
        speed.spectral_seconds_to_evaluate,
        percent(speed.pixel_noise.c),
        percent(speed.pixel_noise.a),
        percent(speed.pixel_noise.mu)
    );
    let _ = writeln!(
        text,
        "{:<12}{:>8}{:>10}{:>9}{:>10}{:>11}{:>9}{:>34}{:>24}",
        "",
        "samples",
        "estimate",
        "draw",
        "evaluate",
        "G samples",
        "",
        "error (%) against closed form",
        "gradient noise (%)"
    );
    let _ = writeln!(
        text,
        "{:<12}{:>8}{:>10}{:>9}{:>10}{:>11}{:>9}{:>12}{:>11}{:>11}{:>13}{:>11}",
        "sequence", "a pixel", "s", "s", "s", "/s", "rounds", "c", "a", "mu", "by ln c", "by ln a"
    );
    for row in &speed.rows {
        let _ = writeln!(
            text,
            "{:<12}{:>8}{:>10.3}{:>9.3}{:>10.4}{:>11.3}{:>9}{:>12}{:>11}{:>11}{:>13}{:>11}",
            row.sequence.name(),
            row.samples,
            row.seconds,
            row.seconds_to_draw,
            row.seconds_to_evaluate,
            row.samples_in_all as f64 / row.seconds_to_evaluate / 1e9,
            row.iterations,
            percent(row.errors.c),
            percent(row.errors.a),
            percent(row.errors.mu),
            percent(row.gradient_noise[1]),
            percent(row.gradient_noise[0])
        );
    }
    text
}
