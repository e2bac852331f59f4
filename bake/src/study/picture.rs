//! Picture of a study: error against rays and against seconds, on logarithmic axes.

use crate::error::Error;
use crate::plots::render;
use crate::rays::Tracer;
use crate::study::report::{slope_text, title};
use crate::study::study::{Point, Reference, Series, Study};
use kuva::plot::{LinePlot, ScatterPlot};
use kuva::prelude::{LegendPosition, ReferenceLine, TickFormat};
use kuva::render::figure::Figure;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use std::path::Path;
use std::sync::Arc;
use tables::options::Sampler;

/// Draws the study in the format of `file`, .png or .svg, and returns the bytes of that file.
///
/// # Errors
/// Returns [`Error`] if the extension of `file` is neither, or the picture cannot be rendered.
pub(crate) fn draw(study: &Study, file: &Path) -> Result<Vec<u8>, Error> {
    let (plots, layouts) = [by_rays(study), by_seconds(study)].into_iter().unzip();
    let heading = format!(
        "{}: {} directions, {} x {} bins; L1 error per launched ray",
        study.design, study.directions, study.bins, study.bins
    );
    let scene = Figure::new(1, 2)
        .with_title(heading)
        .with_title_size(16)
        .with_plots(plots)
        .with_layouts(layouts)
        .with_cell_size(560.0, 480.0)
        .render();
    render(&scene, file)
}

/// Returns logarithmic axes that fit the plots, or empty axes if nothing above zero is drawn.
fn axes(plots: &[Plot]) -> Layout {
    let holds = |plot: &Plot| matches!(plot, Plot::Line(line) if !line.data.is_empty());
    match plots.iter().any(holds) {
        true => Layout::auto_from_plots(plots).with_log_scale(),
        false => Layout::new((0.0, 1.0), (0.0, 1.0)),
    }
}

/// Returns the colour of a series: hue by sampler, pale if rays are traced one by one.
const fn colour(series: &Series) -> &'static str {
    match (series.tracer, series.sampler) {
        (Tracer::Fastest, Sampler::Random) => "#1f77b4",
        (Tracer::Fastest, Sampler::Sobol) => "#d62728",
        (Tracer::OneByOne, Sampler::Random) => "#7fb2d9",
        (Tracer::OneByOne, Sampler::Sobol) => "#e99a9b",
    }
}

/// Draws a series as dots joined by a line; points with a zero coordinate are left out.
///
/// The line is dashed for [`Tracer::OneByOne`], whose errors are those of [`Tracer::Fastest`].
fn curve(series: &Series, legend: String, coordinates: impl Fn(&Point) -> (f64, f64)) -> Vec<Plot> {
    // A logarithmic axis has no place for zero.
    let points: Vec<(f64, f64)> = series
        .points
        .iter()
        .map(coordinates)
        .filter(|&(x, y)| x > 0.0 && y > 0.0)
        .collect();
    let dots = ScatterPlot::new()
        .with_data(points.clone())
        .with_color(colour(series))
        .with_size(3.5);
    let line = LinePlot::new()
        .with_data(points)
        .with_color(colour(series))
        .with_stroke_width(1.5)
        .with_legend(legend);
    let line = match series.tracer {
        Tracer::Fastest => line,
        Tracer::OneByOne => line.with_dashed(),
    };
    vec![Plot::Line(line), Plot::Scatter(dots)]
}

/// Returns the format of ticks as decimal numbers: 0.02, not 2e-2.
fn decimal() -> TickFormat {
    TickFormat::Custom(Arc::new(|value| {
        let places = (-value.log10().floor()).max(0.0) as usize;
        format!("{value:.places$}")
    }))
}

/// Returns the format of ticks as powers of ten: 5e4, not 50000.
fn powers_of_ten() -> TickFormat {
    TickFormat::Custom(Arc::new(|value| format!("{value:.0e}")))
}

/// Draws the mean L1 error against rays per direction, with the fitted slopes in the legend.
fn by_rays(study: &Study) -> (Vec<Plot>, Layout) {
    let mut plots = Vec::new();
    for series in &study.series {
        let legend = format!("{}: slope {}", title(series), slope_text(series));
        plots.extend(curve(series, legend, |point| (point.rays as f64, point.l1)));
    }
    let layout = axes(&plots)
        .with_tick_format(decimal())
        .with_x_tick_format(powers_of_ten())
        .with_title("error and rays")
        .with_x_label("rays per direction")
        .with_y_label("L1 error, mean over directions")
        .with_legend_position(LegendPosition::InsideBottomLeft);
    (plots, layout)
}

/// Draws the L1 error of the worst direction against seconds, with the exact method's time.
fn by_seconds(study: &Study) -> (Vec<Plot>, Layout) {
    let mut plots = Vec::new();
    for series in &study.series {
        plots.extend(curve(series, title(series), |point| {
            (point.seconds, point.worst_l1)
        }));
    }
    let exact = match study.reference {
        Reference::Exact { seconds } => Some(seconds),
        Reference::Sobol { .. } => None,
    };
    let points = || study.series.iter().flat_map(|series| &series.points);
    let shortest = points()
        .map(|point| point.seconds)
        .chain(exact)
        .fold(f64::INFINITY, f64::min);
    let mut layout = axes(&plots)
        .with_tick_format(decimal())
        .with_title("error and time")
        .with_x_label("seconds for all directions")
        .with_y_label("L1 error, worst direction")
        .with_x_axis_min(shortest / 1.5)
        .with_legend_position(LegendPosition::InsideBottomLeft)
        .with_reference_line(
            ReferenceLine::horizontal(study.target)
                .with_color("#555555")
                .with_label(format!("L1 = {}", study.target)),
        );
    if let Some(seconds) = exact {
        let label = format!("exact: {:.2} ms, no sampling error", 1e3 * seconds);
        layout = layout.with_reference_line(
            ReferenceLine::vertical(seconds)
                .with_color("#2ca02c")
                .with_stroke_width(2.0)
                .with_label(label),
        );
    }
    (plots, layout)
}
