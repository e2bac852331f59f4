//! Pictures of a study.

use std::path::Path;

use kuva::prelude::*;

use crate::estimate::Kind;
use crate::report::plot::{Error, draw};
use crate::study::Study;
use crate::study::summary::Row;
use crate::study::{Figure, Summary};
use crate::study::{LOSSES, PARAMETERS};

/// Returns the colour of a loss.
fn colour(loss: Kind) -> &'static str {
    match loss {
        Kind::Mtf => "#d62728",
        Kind::Mse => "#2ca02c",
        Kind::Edge => "#1f77b4",
    }
}

/// Draws the root-mean-square error over the bound, and the coverage, of every parameter under both
/// losses.
///
/// Bars show one standard deviation.
///
/// # Errors
/// Returns [`Error::Drawing`] if the library cannot draw the picture, and [`Error::Format`] if the
/// ending of the file is no format of plots.
pub(crate) fn drawn(summary: &Summary, path: &Path) -> Result<Vec<u8>, Error> {
    type Of = fn(&Row) -> Figure;
    let percent = |f: Figure| Figure {
        value: 100.0 * f.value,
        error: 100.0 * f.error,
    };
    let panel = |label: &str, level: f64, of: &dyn Fn(&Row) -> Figure| {
        let dots = |(k, loss): (usize, Kind)| {
            let rows: Vec<&Row> = summary.rows.iter().filter(|row| row.loss == loss).collect();
            // The losses are drawn side by side over the name of their parameter.
            let place = |i: usize| i as f64 + 1.0 + 0.16 * (k as f64 - 0.5);
            let points = rows
                .iter()
                .enumerate()
                .map(|(i, row)| (place(i), of(row).value));
            Plot::Scatter(
                ScatterPlot::new()
                    .with_data(points.collect::<Vec<(f64, f64)>>())
                    .with_y_err(rows.iter().map(|row| of(row).error))
                    .with_color(colour(loss))
                    .with_size(5.0)
                    .with_legend(loss.name()),
            )
        };
        let plots: Vec<Plot> = LOSSES.into_iter().enumerate().map(dots).collect();
        let names = PARAMETERS.map(String::from).to_vec();
        let layout = Layout::auto_from_plots(&plots)
            .with_y_label(label)
            .with_x_categories(names)
            .with_x_axis_min(0.5)
            .with_x_axis_max(PARAMETERS.len() as f64 + 0.5)
            .with_reference_line(ReferenceLine::horizontal(level));
        (plots, layout)
    };
    let figures: [(&str, f64, Of); 2] = [
        ("RMSE / Cramer-Rao bound", 1.0, |row| row.rmse_over_bound),
        ("coverage of 95 % intervals (%)", 95.0, |row| row.coverage),
    ];
    let [(label, level, rmse), (other, nominal, coverage)] = figures;
    let (panels, layouts) = [
        panel(label, level, &rmse),
        panel(other, nominal, &|row| percent(coverage(row))),
    ]
    .into_iter()
    .unzip();
    let title = format!(
        "{} campaigns counted of {}",
        summary.counted, summary.campaigns
    );
    draw(panels, layouts, &title, path)
}

/// Draws the standard error over the bound against the seconds of the fit, for every fit of the
/// chosen kernel.
///
/// # Errors
/// Returns [`Error::Drawing`] if the library cannot draw the picture, and [`Error::Format`] if the
/// ending of the file is no format of plots.
pub(crate) fn photographs(study: &Study, path: &Path) -> Result<Vec<u8>, Error> {
    let fits = study
        .fits
        .iter()
        .filter_map(|fit| Some((fit, fit.error_over_bound?)));
    let plots: Vec<Plot> = fits
        .map(|(fit, error)| {
            Plot::Scatter(
                ScatterPlot::new()
                    .with_data(vec![(fit.seconds, error)])
                    .with_color(colour(fit.loss))
                    .with_size(6.0)
                    .with_legend(fit.loss.name()),
            )
        })
        .collect();
    let layout = Layout::auto_from_plots(&plots)
        .with_x_label("seconds of the fit")
        .with_y_label("standard error / Cramer-Rao bound")
        .with_x_axis_min(0.0)
        .with_y_axis_min(0.0)
        .with_reference_line(ReferenceLine::horizontal(1.0));
    let title = format!(
        "{} photographs, kernel {}",
        study.photographs,
        study.kernel.name()
    );
    draw(vec![plots], vec![layout], &title, path)
}
