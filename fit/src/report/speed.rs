//! Picture of the study of forward models: error against samples and against time.

use std::path::Path;

use kuva::prelude::*;

use crate::report::plot::{Error, draw};
use crate::samples::Sequence;
use crate::study::Speed;
use crate::study::forward::Row;

/// Draws the error against samples per pixel and against seconds, with both axes logarithmic.
///
/// # Errors
/// Returns [`Error::Drawing`] if the library cannot draw the picture, and [`Error::Format`] if the
/// ending of the file is no format of plots.
pub(crate) fn drawn(speed: &Speed, path: &Path) -> Result<Vec<u8>, Error> {
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
    draw(panels, vec![by_samples, by_seconds], &title, path)
}

/// Name of a parameter, and a function that returns its error.
type Named = (&'static str, fn(&Row) -> Option<f64>);

/// Parameters whose errors are drawn.
const ERRORS: [Named; 2] = [("c", |row| row.errors.c), ("a", |row| row.errors.a)];

/// Draws one curve per sequence and parameter against the variable `x`.
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

/// Makes the axes of one panel, with the standard error of c as a line.
fn panel(speed: &Speed, x: impl Fn(&Row) -> f64) -> Layout {
    let curves = curves(speed, x);
    // Without a value above zero, logarithmic axes cannot be drawn.
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
