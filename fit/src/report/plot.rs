//! Pictures of MTF curves, measured, modelled and predicted.

use std::path::{Path, PathBuf};

use kuva::prelude::*;
use tables::cli::PlotFormat;

use crate::predict::{Around, Axis, Prediction};
use crate::report::labels::{End, Labels};
use crate::result::ResultFile;

/// Reason why a picture cannot be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum Error {
    /// Ending of a file that is no format of plots.
    #[error(transparent)]
    Format(#[from] tables::Error),
    /// Picture that the drawing library cannot draw.
    #[error("{}: the plot could not be drawn ({message}); try the other of .svg and .png",
        path.display())]
    Drawing { path: PathBuf, message: String },
}

/// Colours of the curves of one panel, by photograph.
pub(crate) const COLOURS: [&str; 6] = [
    "#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#17becf",
];

/// MTF below which the rest of a curve is not shown.
const LOW: f64 = 0.02;

/// Largest number of curves whose legend stands in the panel.
pub(crate) const INSIDE: usize = 4;

/// Returns the place of the legend of a panel: beside it if it would cover curves.
pub(crate) fn legend_of(curves: usize) -> LegendPosition {
    match curves > INSIDE {
        true => LegendPosition::OutsideRightTop,
        false => LegendPosition::InsideTopRight,
    }
}

/// Returns the highest frequency at which a curve of an MTF is above [`LOW`].
fn farthest<'a>(curves: impl Iterator<Item = (&'a [f64], &'a [f64])>) -> Option<f64> {
    curves
        .flat_map(|(frequency, mtf)| frequency.iter().zip(mtf))
        .filter(|(_, mtf)| **mtf > LOW)
        .map(|(&frequency, _)| frequency)
        .max_by(f64::total_cmp)
}

/// Returns the frequency that follows the last one at which a curve is seen; the last of all if
/// none follows, or if no curve is seen.
fn end_of<'a>(frequency_per_mm: &'a [f64], curves: impl Iterator<Item = &'a [f64]>) -> f64 {
    let last = farthest(curves.map(|mtf| (frequency_per_mm, mtf)));
    let all = || frequency_per_mm.iter().copied();
    let following = last.and_then(|last| all().filter(|&f| f > last).min_by(f64::total_cmp));
    following.unwrap_or_else(|| all().fold(0.0, f64::max))
}

/// Returns the values in ascending order, each once.
fn distinct(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// Draws the measured MTF (dots, with one standard error) and the model (line).
///
/// There is one panel per incidence angle. The curves of every second distance are thin and dashed,
/// and the others wide, so that curves that coincide are both seen.
///
/// # Errors
/// Returns [`Error::Drawing`] if the library cannot draw the picture, and [`Error::Format`] if the
/// ending of the file is no format of plots.
pub(crate) fn fitted(result: &ResultFile, path: &Path) -> Result<Vec<u8>, Error> {
    let incidences = distinct(result.captures.iter().map(|c| c.incidence_deg));
    let distances = distinct(result.captures.iter().map(|c| c.floating_distance_mm));
    let curves = result.captures.iter().map(|c| &c.curves);
    let farthest = farthest(curves.map(|c| (&*c.frequency_per_mm, &*c.modelled)));
    let farthest = farthest.unwrap_or(0.5).max(0.5);
    let mut panels = Vec::new();
    let mut layouts = Vec::new();
    for &incidence in &incidences {
        let mut plots = Vec::new();
        let shots = result
            .captures
            .iter()
            .filter(|c| c.incidence_deg == incidence);
        for (i, shot) in shots.enumerate() {
            let colour = COLOURS[i % COLOURS.len()];
            let curves = &shot.curves;
            let shown = curves
                .frequency_per_mm
                .iter()
                .take_while(|&&f| f <= farthest)
                .count();
            let points = |y: &[f64]| -> Vec<(f64, f64)> {
                curves.frequency_per_mm[..shown]
                    .iter()
                    .copied()
                    .zip(y.iter().copied())
                    .collect()
            };
            let name = format!(
                "{} mm, edge {:.0}°",
                shot.floating_distance_mm, shot.edge_angle_deg
            );
            let place = distances.partition_point(|&mm| mm < shot.floating_distance_mm);
            let below = place % 2 == 0;
            plots.push(Plot::Scatter(
                ScatterPlot::new()
                    .with_data(points(&curves.measured))
                    .with_y_err(curves.standard_error[..shown].iter().copied())
                    .with_color(colour)
                    .with_size(if below { 4.0 } else { 2.0 }),
            ));
            let line = LinePlot::new()
                .with_data(points(&curves.modelled))
                .with_color(colour)
                .with_stroke_width(if below { 4.0 } else { 1.5 })
                .with_legend(name);
            plots.push(Plot::Line(match below {
                true => line,
                false => line.with_dashed(),
            }));
        }
        let layout = Layout::auto_from_plots(&plots)
            .with_title(format!("incidence {incidence}°"))
            .with_x_label("frequency (1/mm)")
            .with_y_label("MTF")
            .with_x_axis_min(0.0)
            .with_x_axis_max(farthest)
            .with_y_axis_min(0.0)
            .with_y_axis_max(1.0)
            .with_legend_position(legend_of(plots.len() / 2));
        panels.push(plots);
        layouts.push(layout);
    }
    let title = format!(
        "MTF measured (dots) and modelled (lines), kernel {}",
        result.kernel.name()
    );
    draw(panels, layouts, &title, path)
}

/// Draws the predicted MTF: one panel per distance and axis, one curve per incidence.
///
/// The frequencies end where the last curve does.
///
/// # Errors
/// Returns [`Error::Drawing`] if the library cannot draw the picture, and [`Error::Format`] if the
/// ending of the file is no format of plots.
pub(crate) fn predicted(
    predictions: &[Prediction],
    frequency_per_mm: &[f64],
    path: &Path,
) -> Result<Vec<u8>, Error> {
    let distances = distinct(predictions.iter().map(|p| p.floating_distance_mm));
    let end = end_of(frequency_per_mm, predictions.iter().map(|p| &*p.mtf));
    let mut panels = Vec::new();
    let mut layouts = Vec::new();
    for axis in [Axis::Tangential, Axis::Sagittal] {
        for &distance in &distances {
            let chosen: Vec<&Prediction> = predictions
                .iter()
                .filter(|p| {
                    p.axis == axis && p.floating_distance_mm == distance && !p.mtf.is_empty()
                })
                .collect();
            let last = chosen.len().max(2) - 1;
            let lines: Vec<Line> = chosen
                .iter()
                .enumerate()
                .map(|(i, p)| {
                    let points = frequency_per_mm.iter().copied().zip(p.mtf.iter().copied());
                    let within = |f: f64| f <= end;
                    let ends = frequency_per_mm.iter().zip(&p.mtf_interval);
                    Line {
                        name: format!("{}°", p.incidence_deg),
                        colour: ramp(i as f64 / last as f64),
                        points: points.filter(|point| within(point.0)).collect(),
                        intervals: ends.filter(|(f, _)| within(**f)).map(|(_, e)| *e).collect(),
                        outside: !p.outside.is_empty(),
                    }
                })
                .collect();
            let legend = legend_of(lines.len());
            let (plots, labels) = named(lines);
            let all_outside = chosen.iter().all(|p| !p.outside.is_empty());
            let shaded = all_outside.then_some([0.0, end]);
            let name = if axis == Axis::Tangential {
                "tangential"
            } else {
                "sagittal"
            };
            let layout = Layout::auto_from_plots(&plots)
                .with_title(format!("{distance} mm, {name}"))
                .with_x_label("frequency (1/mm)")
                .with_y_label("MTF")
                .with_x_axis_min(0.0)
                .with_x_axis_max(end)
                .with_y_axis_min(0.0)
                .with_y_axis_max(1.0)
                .with_legend_position(legend);
            panels.push(plots);
            layouts.push(with_shades(with_labels(layout, labels), shaded));
        }
    }
    draw(
        panels,
        layouts,
        "MTF of the mid-air image by incidence",
        path,
    )
}

/// Variable on the horizontal axis of a plot of the MTF at single frequencies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Variable {
    /// Incidence angle
    Incidence,
    /// Azimuth
    Azimuth,
    /// Floating distance
    Distance,
    /// Direction of contrast, all around, as polar curves
    Direction,
}

impl Variable {
    /// Returns the value of the variable at a place, or `None` for the azimuth of a mean table.
    fn of(self, p: &Prediction) -> Option<f64> {
        match self {
            Variable::Incidence => Some(p.incidence_deg),
            Variable::Azimuth => p.azimuth_deg,
            Variable::Distance => Some(p.floating_distance_mm),
            Variable::Direction => None,
        }
    }

    /// Describes the value of the variable at a place, for example "incidence 20°".
    fn words(self, p: &Prediction) -> Option<String> {
        let value = self.of(p)?;
        Some(match self {
            Variable::Incidence => format!("incidence {value}°"),
            Variable::Azimuth => format!("azimuth {value}°"),
            Variable::Distance => format!("{value} mm"),
            Variable::Direction => return None,
        })
    }
}

/// Draws the predicted MTF at each frequency against one variable.
///
/// The plot follows Kakinuma et al. 2021 (OSA Continuum 4, 865): one panel per axis, one curve per
/// frequency and per combination of the other variables. If nothing returns at a place, it has no
/// point.
///
/// # Errors
/// Returns [`Error::Drawing`] if the library cannot draw the picture, and [`Error::Format`] if the
/// ending of the file is no format of plots.
pub(crate) fn against(
    predictions: &[Prediction],
    frequency_per_mm: &[f64],
    variable: Variable,
    path: &Path,
) -> Result<Vec<u8>, Error> {
    let varies = |v: &Variable| predictions.windows(2).any(|p| v.of(&p[0]) != v.of(&p[1]));
    let others: Vec<Variable> = [Variable::Distance, Variable::Incidence, Variable::Azimuth]
        .into_iter()
        .filter(|v| *v != variable && varies(v))
        .collect();
    // The name of a curve holds its frequency and this text.
    let place = |p: &Prediction| -> String {
        let words = others.iter().filter_map(|v| v.words(p));
        words.map(|words| format!(", {words}")).collect()
    };
    let mut places: Vec<String> = Vec::new();
    for name in predictions.iter().map(place) {
        if !places.contains(&name) {
            places.push(name);
        }
    }
    let mut panels = Vec::new();
    let mut layouts = Vec::new();
    for (axis, name) in [
        (Axis::Tangential, "tangential"),
        (Axis::Sagittal, "sagittal"),
    ] {
        let curves = places
            .iter()
            .flat_map(|name| (0..frequency_per_mm.len()).map(move |k| (name, k)));
        let last = (places.len() * frequency_per_mm.len()).max(2) - 1;
        let lines: Vec<Line> = curves
            .enumerate()
            .map(|(i, (name, k))| {
                let chosen = predictions
                    .iter()
                    .filter(|p| p.axis == axis && place(p) == *name);
                let mut chosen: Vec<(f64, &Prediction)> = chosen
                    .filter_map(|p| Some((variable.of(p)?, p)))
                    .filter(|(_, p)| k < p.mtf.len())
                    .collect();
                chosen.sort_by(|a, b| a.0.total_cmp(&b.0));
                Line {
                    name: format!("{} /mm{name}", frequency_per_mm[k]),
                    colour: ramp(i as f64 / last as f64),
                    points: chosen.iter().map(|(x, p)| (*x, p.mtf[k])).collect(),
                    intervals: (chosen.iter())
                        .filter_map(|(_, p)| p.mtf_interval.get(k).copied())
                        .collect(),
                    outside: chosen.iter().all(|(_, p)| !p.outside.is_empty()),
                }
            })
            .collect();
        let (plots, labels) = named(lines);
        let label = match variable {
            Variable::Incidence => "incidence (°)",
            Variable::Azimuth => "azimuth (°)",
            Variable::Distance => "floating distance (mm)",
            Variable::Direction => "direction (°)",
        };
        let layout = Layout::auto_from_plots(&plots)
            .with_title(name)
            .with_x_label(label)
            .with_y_label("MTF")
            .with_y_axis_min(0.0)
            .with_y_axis_max(1.0)
            .with_legend_position(LegendPosition::OutsideRightTop);
        panels.push(plots);
        let layout = with_labels(layout, labels);
        layouts.push(with_shades(layout, outside(predictions, variable)));
    }
    draw(panels, layouts, "MTF of the mid-air image", path)
}

/// Line of predictions.
struct Line {
    name: String,
    colour: String,
    points: Vec<(f64, f64)>,
    /// Ends of the interval of each point; fewer than points without covariance.
    intervals: Vec<[f64; 2]>,
    /// True if all points lie outside of the photographs.
    outside: bool,
}

impl Line {
    /// Returns the name that the reader sees.
    fn shown_name(&self) -> String {
        match self.outside {
            true => format!("{}, outside", self.name),
            false => self.name.clone(),
        }
    }

    /// Draws the line with the band of its intervals, dashed if it lies outside of the photographs.
    fn drawn(self, in_legend: bool) -> Plot {
        let has_band = self.intervals.len() == self.points.len();
        let name = self.shown_name();
        let mut line = LinePlot::new()
            .with_data(self.points)
            .with_color(self.colour)
            .with_stroke_width(1.5);
        if has_band {
            let end = |k: usize| self.intervals.iter().map(move |ends| ends[k]);
            line = line.with_band(end(0), end(1));
        }
        if self.outside {
            line = line.with_dashed();
        }
        Plot::Line(if in_legend {
            line.with_legend(name)
        } else {
            line
        })
    }
}

/// Draws lines with their names at their ends, or in a legend where these would collide.
fn named(lines: Vec<Line>) -> (Vec<Plot>, Option<Labels>) {
    let first = lines.iter().filter_map(|line| line.points.first());
    let first = first.map(|point| point.0).fold(f64::INFINITY, f64::min);
    let end = |line: &Line| {
        Some(End {
            name: line.shown_name(),
            point: *line.points.last()?,
        })
    };
    let ends: Vec<End> = lines.iter().filter_map(end).collect();
    let labels = Labels::of(&ends, first);
    let in_legend = labels.is_none();
    let plots = lines.into_iter().map(|line| line.drawn(in_legend));
    (plots.collect(), labels)
}

/// Adds the names of curves to a panel.
fn with_labels(layout: Layout, labels: Option<Labels>) -> Layout {
    match labels {
        Some(labels) => labels.on(layout),
        None => layout,
    }
}

/// Returns the ranges of a variable in which all predictions lie outside of the photographs. A
/// range reaches to the next prediction that does not.
fn outside(predictions: &[Prediction], variable: Variable) -> Vec<[f64; 2]> {
    let mut places: Vec<(f64, bool)> = predictions
        .iter()
        .filter_map(|p| Some((variable.of(p)?, !p.outside.is_empty())))
        .collect();
    // Of equal places one that lies within the photographs comes first and stays.
    places.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    places.dedup_by_key(|place| place.0);
    let pairs = places.windows(2).filter(|pair| pair[0].1 || pair[1].1);
    pairs.map(|pair| [pair[0].0, pair[1].0]).collect()
}

/// Shades ranges of the horizontal axis.
fn with_shades(layout: Layout, ranges: impl IntoIterator<Item = [f64; 2]>) -> Layout {
    ranges.into_iter().fold(layout, |layout, [from, to]| {
        let region = ShadedRegion::vertical(from, to).with_color("#888888");
        layout.with_shaded_region(region)
    })
}

/// Draws the predicted MTF at each frequency over the direction of contrast.
///
/// There is one polar panel per place, with 0° (tangential) to the right and 90° (sagittal)
/// upwards. A circle means that the blur is equal in all directions.
///
/// # Errors
/// Returns [`Error::Drawing`] if the library cannot draw the picture, and [`Error::Format`] if the
/// ending of the file is no format of plots.
pub(crate) fn around(
    all: &[Around],
    frequency_per_mm: &[f64],
    path: &Path,
) -> Result<Vec<u8>, Error> {
    let last = frequency_per_mm.len().max(2) - 1;
    let panel = |place: &Around| {
        let polar = PolarPlot::new()
            .with_theta_start(90.0)
            .with_clockwise(false)
            .with_r_max(1.0)
            .with_r_grid_lines(2)
            .with_legend(true);
        let curves = place.mtf.iter().zip(frequency_per_mm).enumerate();
        let polar = curves.fold(polar, |polar, (k, (mtf, frequency))| {
            let name = format!("{frequency} /mm");
            let (r, theta) = (mtf.iter().copied(), place.direction_deg.iter().copied());
            polar
                .with_series_labeled(r, theta, name, PolarMode::Line)
                .with_color(ramp(k as f64 / last as f64))
        });
        vec![Plot::Polar(polar)]
    };
    let panels: Vec<Vec<Plot>> = all.iter().map(panel).collect();
    let layout = |(plots, place): (&Vec<Plot>, &Around)| {
        let azimuth = place
            .azimuth_deg
            .map_or(String::new(), |a| format!(", azimuth {a}°"));
        let (distance, incidence) = (place.floating_distance_mm, place.incidence_deg);
        let returns = if place.mtf.is_empty() {
            ": nothing returns"
        } else {
            ""
        };
        let title = format!("{distance} mm, incidence {incidence}°{azimuth}{returns}");
        Layout::auto_from_plots(plots).with_title(title)
    };
    let layouts = panels.iter().zip(all).map(layout).collect();
    let title = "MTF by direction of contrast: 0° tangential, 90° sagittal";
    draw(panels, layouts, title, path)
}

/// Colours of an ordered scale, from dark to light: matplotlib's viridis (CC0) in steps of an
/// eighth, up to 0.625, so that the lightest line is still seen on white.
///
/// Its lightness grows evenly, so people who do not see all colours can still tell the order.
const SCALE: [[f64; 3]; 6] = [
    [68.0, 1.0, 84.0],
    [71.0, 45.0, 123.0],
    [59.0, 82.0, 139.0],
    [44.0, 114.0, 142.0],
    [33.0, 145.0, 140.0],
    [40.0, 174.0, 128.0],
];

/// Returns a colour of the ordered scale, from dark (0) to light (1).
fn ramp(x: f64) -> String {
    let place = x.clamp(0.0, 1.0) * (SCALE.len() - 1) as f64;
    let left = (place as usize).min(SCALE.len() - 2);
    let share = place - left as f64;
    let [r, g, b] =
        [0, 1, 2].map(|k| (SCALE[left][k] * (1.0 - share) + SCALE[left + 1][k] * share).round());
    format!("#{:02x}{:02x}{:02x}", r as u8, g as u8, b as u8)
}

/// Draws panels under one title.
///
/// # Errors
/// Returns [`Error::Drawing`] if the library cannot draw the picture, and [`Error::Format`] if the
/// ending of the file is no format of plots.
pub(crate) fn draw(
    panels: Vec<Vec<Plot>>,
    layouts: Vec<Layout>,
    title: &str,
    path: &Path,
) -> Result<Vec<u8>, Error> {
    let columns = panels.len().clamp(1, if panels.len() > 4 { 5 } else { 2 });
    let rows = panels.len().div_ceil(columns);
    let figure = Figure::new(rows, columns)
        .with_title(title)
        .with_plots(panels)
        .with_layouts(layouts)
        .with_cell_size(380.0, 320.0);
    encoded(figure, path)
}

/// Draws a figure in the format that the ending of the file names.
///
/// # Errors
/// Returns [`Error::Drawing`] if the library cannot draw the picture, and [`Error::Format`] if the
/// ending of the file is no format of plots.
pub(crate) fn encoded(figure: Figure, path: &Path) -> Result<Vec<u8>, Error> {
    let scene = figure.render();
    match PlotFormat::of(path)? {
        PlotFormat::Svg => Ok(SvgBackend.render_scene(&scene).into_bytes()),
        PlotFormat::Png => {
            PngBackend::new()
                .render_scene(&scene)
                .map_err(|message| Error::Drawing {
                    path: path.to_owned(),
                    message: message.to_string(),
                })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that the axis ends behind the last curve, and that nothing is lost where no curve is
    /// seen or none ends.
    #[test]
    fn the_axis_ends_where_the_last_curve_does() {
        let frequency = [0.0, 0.5, 1.0, 1.5, 2.0];
        let short = [1.0, 0.3, 0.0, 0.0, 0.0];
        let long = [1.0, 0.9, 0.5, 0.03, 0.0];
        let end = |all: &[&[f64]]| end_of(&frequency, all.iter().copied());
        assert_eq!(end(&[&short, &long]), 2.0);
        assert_eq!(end(&[&short]), 1.0);
        assert_eq!(end(&[&[1.0; 5]]), 2.0);
        assert_eq!(end(&[&[0.0; 5]]), 2.0);
        assert_eq!(end(&[]), 2.0);
    }

    /// Checks at 101 places that the scale grows lighter, and that its lightest colour has a
    /// contrast of 2.8 with white (relative luminance of WCAG 2).
    #[test]
    fn the_scale_of_colours_is_ordered_by_lightness() {
        let luminance = |colour: &str| -> f64 {
            let channel = |k: usize| {
                let value = u8::from_str_radix(&colour[k..k + 2], 16).expect("two digits") as f64;
                let value = value / 255.0;
                match value <= 0.03928 {
                    true => value / 12.92,
                    false => ((value + 0.055) / 1.055).powf(2.4),
                }
            };
            0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5)
        };
        let all: Vec<f64> = (0..=100)
            .map(|k| luminance(&ramp(k as f64 / 100.0)))
            .collect();
        assert!(all.windows(2).all(|pair| pair[0] < pair[1]), "{all:?}");
        let contrast = 1.05 / (all[100] + 0.05);
        assert!(contrast > 2.8, "{contrast}");
    }
}
