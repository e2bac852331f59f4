//! Pictures of MTF curves, measured, modelled and predicted.

use charts::{Axis, Curve, Dash, Facet, Figure, Ground, HUES, Key, Marks, Stroke, ramp};

use estimator::predict::{Around, Axis as Contrast, Prediction};
use estimator::result::{CaptureResult, ResultFile};

/// MTF below which the rest of a curve is not shown.
const LOW: f64 = 0.02;

/// The same for a measured curve, and how much farther its axis reaches.
const MEASURED_LOW: f64 = 0.05;
const ROOM: f64 = 1.3;

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

/// Returns the line of curve number `index` of curves without an order.
fn unordered(index: usize) -> Stroke {
    Stroke {
        colour: HUES[index % HUES.len()].into(),
        dash: Dash::ALL[index % Dash::ALL.len()],
    }
}

/// Makes a panel of MTF curves over the frequency.
fn panel(head: String, end: f64, unit: &str, curves: Vec<Curve>) -> Facet {
    let axes = [Axis::linear(0.0, end), Axis::linear(0.0, 1.0)];
    Facet::new(head, axes, [&format!("frequency ({unit})"), "MTF"], curves)
}

/// Returns how many panels stand beside each other, in rows as even as can be.
fn beside(panels: usize) -> usize {
    match panels {
        0..=4 => 2,
        many => many.div_ceil(many.div_ceil(5)),
    }
}

/// Measured MTF of one photograph.
pub struct Shown<'a> {
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

impl Shown<'_> {
    /// Returns the frequency up to which the curve is worth showing.
    fn reach(&self) -> f64 {
        let last = self.frequency.last().copied().unwrap_or(1.0);
        let low = self.mtf.iter().position(|&mtf| mtf < MEASURED_LOW);
        low.map_or(last, |low| (ROOM * self.frequency[low]).min(last))
    }
}

/// Draws measured curves as SVG, with a band of one standard error and a dot at each MTF50.
pub fn measured(all: &[Shown], unit: &str) -> String {
    let end = all.iter().map(Shown::reach).fold(0.0, f64::max);
    let curves = all.iter().enumerate().flat_map(|(i, shown)| {
        let points = shown.frequency.iter().zip(shown.mtf).map(|(&f, &m)| [f, m]);
        let points = points.take_while(|point| point[0] <= end);
        let errors = shown.mtf.iter().zip(shown.standard_error);
        let errors = errors.map(|(m, e)| [m - e, m + e]);
        let name = match shown.half {
            Some(half) => format!("{}: {half:.4}", shown.name),
            None => shown.name.clone(),
        };
        let half = shown.half.map(|half| [half, 0.5]);
        [
            Curve::new(name, unordered(i), Marks::Line, points).within(errors),
            Curve::new("", unordered(i), Marks::Dots, half),
        ]
    });
    let mut panel = panel(String::new(), end, unit, curves.collect());
    let highest = all.iter().flat_map(|shown| shown.mtf).copied();
    if highest.fold(0.0, f64::max) > 1.02 {
        panel.axes[1] = Axis::linear(0.0, 1.2);
    }
    Figure::new(
        "MTF and its standard error; dots mark MTF50",
        vec![panel],
        1,
    )
    .svg()
}

/// Draws the measured MTF (dots, with one standard error) and the model (line) as SVG.
///
/// There is one panel per incidence. Colour and style tell the distances apart; where photographs
/// share both, also upright edges from level ones.
pub fn fitted(result: &ResultFile) -> String {
    let all = &result.captures;
    let incidences = distinct(all.iter().map(|c| c.incidence_deg));
    let curves = all.iter().map(|c| &c.curves);
    let farthest = farthest(curves.map(|c| (&*c.frequency_per_mm, &*c.modelled)));
    let farthest = farthest.unwrap_or(0.5).max(0.5);
    let place = |c: &CaptureResult| (c.incidence_deg, c.floating_distance_mm);
    let is_alone = |c: &CaptureResult| all.iter().filter(|&o| place(o) == place(c)).count() == 1;
    let by_edge = !all.iter().all(is_alone);
    let kind = |c: &CaptureResult| {
        let normal = c.edge_angle_deg.to_radians();
        let is_level = by_edge && normal.sin().abs() > normal.cos().abs();
        (c.floating_distance_mm, is_level)
    };
    let mut kinds: Vec<(f64, bool)> = all.iter().map(kind).collect();
    kinds.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
    kinds.dedup();
    let curves = |capture: &CaptureResult| {
        let (distance, is_level) = kind(capture);
        let own = kinds.iter().position(|&k| k == (distance, is_level));
        let stroke = unordered(own.unwrap_or(0));
        let edge = match (by_edge, is_level) {
            (false, _) => "",
            (true, true) => ", level edge",
            (true, false) => ", upright edge",
        };
        let curves = &capture.curves;
        let points = |y: &[f64]| -> Vec<[f64; 2]> {
            let points = curves.frequency_per_mm.iter().zip(y);
            let points = points.map(|(&f, &m)| [f, m]);
            points.take_while(|point| point[0] <= farthest).collect()
        };
        let errors = curves.measured.iter().zip(&curves.standard_error);
        let errors = errors.map(|(m, e)| [m - e, m + e]);
        let name = format!("{distance} mm{edge}");
        let measured = points(&curves.measured);
        [
            Curve::new("", stroke.clone(), Marks::Dots, measured).within(errors),
            Curve::new(name, stroke, Marks::Line, points(&curves.modelled)),
        ]
    };
    let panels = incidences.iter().map(|&incidence| {
        let own = all.iter().filter(|c| c.incidence_deg == incidence);
        let head = format!("incidence {incidence}\u{b0}");
        panel(head, farthest, "1/mm", own.flat_map(curves).collect())
    });
    let title = format!(
        "MTF measured (dots) and modelled (lines), kernel {}",
        result.kernel.name()
    );
    let panels: Vec<Facet> = panels.collect();
    let columns = beside(panels.len());
    Figure::new(title, panels, columns).svg()
}

/// Draws the predicted MTF as SVG: one panel per distance and axis, one curve per incidence.
///
/// The frequencies end where the last curve does. Curves outside of the photographs are dashed.
pub fn predicted(predictions: &[Prediction], frequency_per_mm: &[f64]) -> String {
    let distances = distinct(predictions.iter().map(|p| p.floating_distance_mm));
    let incidences = distinct(predictions.iter().map(|p| p.incidence_deg));
    let end = end_of(frequency_per_mm, predictions.iter().map(|p| &*p.mtf));
    let is_outside = |p: &Prediction| !p.outside.is_empty();
    let colour = |incidence_deg: f64| {
        let index = incidences.iter().position(|&own| own == incidence_deg);
        ramp(index.unwrap_or(0), incidences.len())
    };
    let curve = |p: &Prediction| {
        let points = frequency_per_mm.iter().zip(&p.mtf).map(|(&f, &m)| [f, m]);
        let suffix = if is_outside(p) { ", outside" } else { "" };
        let stroke = Stroke {
            colour: colour(p.incidence_deg),
            dash: if is_outside(p) {
                Dash::Dashed
            } else {
                Dash::Solid
            },
        };
        let points = points.take_while(|point| point[0] <= end);
        Curve::new(
            format!("{}\u{b0}{suffix}", p.incidence_deg),
            stroke,
            Marks::Line,
            points,
        )
        .within(p.mtf_interval.iter().copied())
    };
    let mut panels = Vec::new();
    for (axis, name) in AXES {
        for &distance in &distances {
            let own = |p: &&Prediction| p.axis == axis && p.floating_distance_mm == distance;
            let own: Vec<&Prediction> = predictions.iter().filter(own).collect();
            let seen = own.iter().filter(|p| !p.mtf.is_empty());
            let curves: Vec<Curve> = seen.map(|p| curve(p)).collect();
            let all_outside = own.iter().all(|p| is_outside(p));
            let mut panel = panel(format!("{distance} mm, {name}"), end, "1/mm", curves);
            panel.shades = all_outside.then_some([0.0, end]).into_iter().collect();
            panel.remark = panel.curves.is_empty().then_some("nothing returns");
            panels.push(panel);
        }
    }
    let columns = if distances.len() == 1 {
        2
    } else {
        distances.len().min(5)
    };
    let mut figure = Figure::new("MTF of the mid-air image by incidence", panels, columns);
    let key = |&incidence: &f64| Key {
        name: format!("{incidence}\u{b0}"),
        stroke: Stroke::solid(colour(incidence)),
    };
    figure.keys = incidences.iter().map(key).collect();
    if predictions.iter().any(is_outside) {
        figure.keys.push(Key {
            name: "outside of the photographs".into(),
            stroke: Stroke::grey(Dash::Dashed),
        });
    }
    figure.svg()
}

/// Axes of contrast, with their names.
const AXES: [(Contrast, &str); 2] = [
    (Contrast::Tangential, "tangential"),
    (Contrast::Sagittal, "sagittal"),
];

/// Variable on the horizontal axis of a plot of the MTF at single frequencies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Variable {
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

    /// Returns the name of an axis with the variable.
    const fn label(self) -> &'static str {
        match self {
            Variable::Incidence => "incidence (\u{b0})",
            Variable::Azimuth => "azimuth (\u{b0})",
            Variable::Distance => "floating distance (mm)",
            Variable::Direction => "direction (\u{b0})",
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

/// Draws the predicted MTF at each frequency against one variable as SVG.
///
/// The plot follows Kakinuma et al. 2021 (OSA Continuum 4, 865): one panel per axis, one curve per
/// frequency and per combination of the other variables. If nothing returns at a place, it has no
/// point. Colours tell combinations apart and styles frequencies, if there are few of these.
pub fn against(predictions: &[Prediction], frequency_per_mm: &[f64], variable: Variable) -> String {
    let varies = |v: &Variable| predictions.windows(2).any(|p| v.of(&p[0]) != v.of(&p[1]));
    let others: Vec<Variable> = [Variable::Distance, Variable::Incidence, Variable::Azimuth]
        .into_iter()
        .filter(|v| *v != variable && varies(v))
        .collect();
    let place = |p: &Prediction| -> String {
        let words = others.iter().filter_map(|v| v.words(p));
        words.collect::<Vec<String>>().join(", ")
    };
    let mut places: Vec<String> = Vec::new();
    for name in predictions.iter().map(place) {
        if !places.contains(&name) {
            places.push(name);
        }
    }
    let frequencies = frequency_per_mm.len();
    let has_styles = places.len() > 1 && frequencies <= Dash::ALL.len();
    let stroke = |i: usize, k: usize| match has_styles {
        true => Stroke {
            colour: ramp(i, places.len()),
            dash: Dash::ALL[k],
        },
        false => Stroke::solid(ramp(i * frequencies + k, places.len() * frequencies)),
    };
    let with_word = |name: &str, of: &[&Prediction]| match of.iter().all(|p| !p.outside.is_empty())
    {
        true => format!("{name}, outside"),
        false => name.to_owned(),
    };
    let at = |name: &str| -> Vec<&Prediction> {
        predictions.iter().filter(|p| place(p) == name).collect()
    };
    let values = predictions.iter().filter_map(|p| variable.of(p));
    let x = match distinct(values)[..] {
        [first, .., last] => Axis::linear(first, last),
        ref few => Axis::around(few.iter().copied()),
    };
    let panels = AXES.map(|(axis, head)| {
        let mut curves = Vec::new();
        for (i, name) in places.iter().enumerate() {
            let value = |p: &Prediction| variable.of(p).unwrap_or(f64::NAN);
            let mut chosen = at(name);
            chosen.retain(|p| p.axis == axis && p.mtf.len() == frequencies);
            chosen.sort_by(|a, b| value(a).total_cmp(&value(b)));
            for (k, frequency) in frequency_per_mm.iter().enumerate() {
                let own = [format!("{frequency} /mm"), with_word(name, &chosen)];
                let points = chosen
                    .iter()
                    .filter_map(|p| Some([variable.of(p)?, p.mtf[k]]));
                let intervals = chosen.iter().filter_map(|p| p.mtf_interval.get(k).copied());
                let name = own[..if name.is_empty() { 1 } else { 2 }].join(", ");
                curves.push(Curve::new(name, stroke(i, k), Marks::Line, points).within(intervals));
            }
        }
        Facet {
            shades: outside(predictions, variable),
            ..Facet::new(
                head,
                [x, Axis::linear(0.0, 1.0)],
                [variable.label(), "MTF"],
                curves,
            )
        }
    });
    let mut figure = Figure::new("MTF of the mid-air image", panels.into(), 2);
    if has_styles {
        let colours = places.iter().enumerate().map(|(i, name)| Key {
            name: with_word(name, &at(name)),
            stroke: Stroke::solid(ramp(i, places.len())),
        });
        let styles = frequency_per_mm
            .iter()
            .zip(Dash::ALL)
            .map(|(frequency, dash)| Key {
                name: format!("{frequency} /mm"),
                stroke: Stroke::grey(dash),
            });
        figure.keys = colours.chain(styles).collect();
    }
    figure.svg()
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

/// Draws the predicted MTF at each frequency over the direction of contrast as SVG.
///
/// There is one polar panel per place, with 0° (tangential) to the right and 90° (sagittal)
/// upwards. A circle means that the blur is equal in all directions.
pub fn around(all: &[Around], frequency_per_mm: &[f64]) -> String {
    let panel = |place: &Around| {
        let curves = place.mtf.iter().zip(frequency_per_mm).enumerate();
        let curves = curves.map(|(k, (mtf, frequency))| {
            let points = mtf.iter().zip(&place.direction_deg).map(|(m, direction)| {
                let (sin, cos) = direction.to_radians().sin_cos();
                [m * cos, m * sin]
            });
            let stroke = Stroke::solid(ramp(k, frequency_per_mm.len()));
            Curve::new(format!("{frequency} /mm"), stroke, Marks::Line, points)
        });
        let (distance, incidence) = (place.floating_distance_mm, place.incidence_deg);
        let azimuth = place
            .azimuth_deg
            .map_or(String::new(), |a| format!(", azimuth {a}\u{b0}"));
        let head = format!("{distance} mm\nincidence {incidence}\u{b0}{azimuth}");
        let axes = [Axis::linear(-1.25, 1.25); 2];
        Facet {
            ground: Ground::Circles,
            remark: place.mtf.is_empty().then_some("nothing returns"),
            ..Facet::new(head, axes, ["", ""], curves.collect())
        }
    };
    let columns = beside(all.len());
    let title = "MTF by direction of contrast: 0\u{b0} tangential, 90\u{b0} sagittal";
    Figure {
        frame: [220.0; 2],
        ..Figure::new(title, all.iter().map(panel).collect(), columns)
    }
    .svg()
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
}
