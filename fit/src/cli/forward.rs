//! `fit study CAPTURES --forward render`: speed against error of the forward models, as a table and a picture.

use std::fmt::Write;
use std::path::Path;

use kuva::prelude::*;

use crate::cli::cli;
use crate::cli::cli::Failure;
use crate::estimate::forward::Forward;
use crate::report::plot;
use crate::samples::sample::Sequence;
use crate::samples::sampled::Sampling;
use crate::study::forward::{Row, Speed};

/// The renders that are studied.
#[derive(Debug, Clone, clap::Args)]
pub struct Renders {
    /// Study a forward model: render times estimates by samples beside the closed form
    #[arg(long, value_enum, conflicts_with = "ranges")]
    pub forward: Option<Forward>,
    /// Samples per pixel of --forward render, a list
    #[arg(long, value_name = "LIST", default_value = "1,4,16,64,256", value_parser = samples, requires = "forward")]
    pub samples: Samples,
    /// Independent randomisations of every number of samples
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u64).range(2..=1000), requires = "forward")]
    pub randomisations: u64,
}

/// Numbers of samples.
#[derive(Debug, Clone)]
pub struct Samples(Vec<usize>);

fn samples(text: &str) -> Result<Samples, String> {
    let list = cli::positives(text)?;
    match list.iter().find(|n| n.fract() != 0.0 || **n > 65_536.0) {
        Some(bad) => Err(format!("{bad} is no whole number from 1 to 65536")),
        None => Ok(Samples(list.into_iter().map(|n| n as usize).collect())),
    }
}

impl Renders {
    /// Every number of samples, evenly spread and independent.
    pub fn samplings(&self, seed: u64) -> Vec<Sampling> {
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

/// The study as a table for a person.
pub fn table(speed: &Speed) -> String {
    let mut text = format!(
        "{} photographs, loss mtf; closed form: {:.4} s for the estimate ({} evaluations), {:.5} s for one evaluation\n\
         standard errors by the pixels' noise: c {} %, a {} %, mu {} %\n",
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

/// Error against samples per pixel and against seconds, both axes logarithmic.
///
/// # Errors
/// [`plot::Error`].
pub fn picture(speed: &Speed, path: &Path) -> Result<Vec<u8>, Failure> {
    let by_samples = panel(speed, |row| row.samples as f64)
        .with_title("error and samples")
        .with_x_label("samples per pixel");
    let by_seconds = panel(speed, |row| row.seconds)
        .with_title("error and time")
        .with_x_label("seconds for the estimate")
        .with_x_axis_min(0.7 * speed.spectral_seconds)
        .with_reference_line(
            ReferenceLine::vertical(speed.spectral_seconds)
                .with_color("#2ca02c")
                .with_label("closed form, no sampling error"),
        );
    let panels = vec![
        curves(speed, |row| row.samples as f64),
        curves(speed, |row| row.seconds),
    ];
    let title = format!("{} photographs: error by the samples", speed.photographs);
    Ok(plot::draw(
        panels,
        vec![by_samples, by_seconds],
        &title,
        path,
    )?)
}

type Error = (&'static str, fn(&Row) -> Option<f64>);

const ERRORS: [Error; 2] = [("c", |row| row.errors.c), ("a", |row| row.errors.a)];

fn curves(speed: &Speed, x: impl Fn(&Row) -> f64) -> Vec<Plot> {
    let mut plots = Vec::new();
    for (sequence, colours) in [
        (Sequence::Sobol, ["#d62728", "#e99a9b"]),
        (Sequence::Independent, ["#1f77b4", "#7fb2d9"]),
    ] {
        for ((name, error), colour) in ERRORS.into_iter().zip(colours) {
            let rows = speed.rows.iter().filter(|row| row.sequence == sequence);
            let points: Vec<(f64, f64)> = rows
                .filter_map(|row| Some((x(row), 100.0 * error(row)?)))
                .filter(|&(x, y)| x > 0.0 && y > 0.0 && y.is_finite())
                .collect();
            if points.is_empty() {
                continue;
            }
            let line = LinePlot::new()
                .with_data(points.clone())
                .with_color(colour)
                .with_stroke_width(1.5)
                .with_legend(format!("{name}, {}", sequence.name()));
            let dots = ScatterPlot::new()
                .with_data(points)
                .with_color(colour)
                .with_size(3.0);
            plots.extend([Plot::Line(line), Plot::Scatter(dots)]);
        }
    }
    plots
}

fn panel(speed: &Speed, x: impl Fn(&Row) -> f64) -> Layout {
    let curves = curves(speed, x);
    // Nothing above zero has no place on logarithmic axes.
    let layout = match curves.is_empty() {
        true => Layout::new((0.0, 1.0), (0.0, 1.0)),
        false => Layout::auto_from_plots(&curves).with_log_scale(),
    };
    let layout = layout
        .with_y_label("error against the closed form (%)")
        .with_legend_position(LegendPosition::InsideTopRight);
    match speed.pixel_noise.c {
        Some(noise) => layout.with_reference_line(
            ReferenceLine::horizontal(100.0 * noise)
                .with_color("#555555")
                .with_label("standard error of c"),
        ),
        None => layout,
    }
}
