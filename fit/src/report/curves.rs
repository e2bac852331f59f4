//! Pictures of MTF curves as measured, one curve per photograph.

use std::path::Path;

use kuva::prelude::*;

use crate::report::plot::{COLOURS, Error, INSIDE, encoded, legend_of};

/// A measured curve.
pub(crate) struct Shown<'a> {
    /// Name in the legend.
    pub name: String,
    /// Frequencies, in the unit of the axis.
    pub frequency: &'a [f64],
    /// MTF at these frequencies.
    pub mtf: &'a [f64],
    /// Standard errors of the MTF.
    pub standard_error: &'a [f64],
    /// MTF50, in the unit of the axis.
    pub half: Option<f64>,
}

/// MTF below which the rest of a curve is not shown, and how much farther the axis reaches.
const LOW: f64 = 0.05;
const ROOM: f64 = 1.3;

/// Draws measured curves with a band of one standard error, and a dot at each MTF50.
///
/// # Errors
/// Returns [`Error::Drawing`] if the library cannot draw the picture, and [`Error::Format`] if the
/// ending of the file is no format of plots.
pub(crate) fn measured(all: &[Shown], unit: &str, path: &Path) -> Result<Vec<u8>, Error> {
    let farthest = all.iter().map(reach).fold(0.0, f64::max);
    let mut plots = Vec::new();
    for (shown, colour) in all.iter().zip(COLOURS.iter().cycle()) {
        let count = shown.frequency.iter().take_while(|&&f| f <= farthest);
        let count = count.count();
        let points = shown.frequency.iter().copied();
        let points: Vec<(f64, f64)> = points.zip(shown.mtf.iter().copied()).take(count).collect();
        let bounds = |sign: f64| -> Vec<f64> {
            let errors = shown.standard_error.iter().zip(shown.mtf);
            errors.take(count).map(|(e, m)| m + sign * e).collect()
        };
        let legend = match shown.half {
            Some(half) => format!("{}: {half:.4}", shown.name),
            None => shown.name.clone(),
        };
        let line = LinePlot::new()
            .with_data(points)
            .with_band(bounds(-1.0), bounds(1.0))
            .with_color(*colour)
            .with_stroke_width(1.5);
        plots.push(Plot::Line(line.with_legend(legend)));
        let dots = ScatterPlot::new()
            .with_data(shown.half.map(|half| (half, 0.5)))
            .with_color(*colour)
            .with_size(4.0);
        plots.push(Plot::Scatter(dots));
    }
    let highest = all.iter().flat_map(|shown| shown.mtf).copied();
    let layout = Layout::auto_from_plots(&plots)
        .with_x_label(format!("frequency ({unit})"))
        .with_y_label("MTF")
        .with_x_axis_min(0.0)
        .with_x_axis_max(farthest)
        .with_y_axis_min(0.0)
        .with_y_axis_max(if highest.fold(0.0, f64::max) > 1.02 {
            1.2
        } else {
            1.0
        })
        .with_legend_position(legend_of(all.len()));
    let figure = Figure::new(1, 1)
        .with_title("MTF and its standard error; dots mark MTF50")
        .with_plots(vec![plots])
        .with_layouts(vec![layout])
        .with_cell_size(if all.len() > INSIDE { 900.0 } else { 640.0 }, 440.0);
    encoded(figure, path)
}

/// Returns the frequency up to which a curve is worth showing.
fn reach(shown: &Shown) -> f64 {
    let last = shown.frequency.last().copied().unwrap_or(1.0);
    let low = shown.mtf.iter().position(|&mtf| mtf < LOW);
    low.map_or(last, |low| (ROOM * shown.frequency[low]).min(last))
}
