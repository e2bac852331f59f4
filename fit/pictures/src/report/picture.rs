//! Pictures of studies.

use charts::{Axis, Curve, Dash, Facet, Figure, HUES, Marks, Stroke};

use estimator::estimate::Kind;
use estimator::samples::Sequence;
use lab::study::forward::Row as Render;
use lab::study::summary::Row;
use lab::study::{Figure as Mean, LOSSES, PARAMETERS, Speed, Study, Summary};

/// Returns the colour of a loss.
fn colour(loss: Kind) -> &'static str {
    match loss {
        Kind::Mtf => HUES[1],
        Kind::Mse => HUES[2],
        Kind::Edge => HUES[0],
    }
}

/// Draws the root-mean-square error over the bound, and the coverage, of every parameter under both
/// losses as SVG.
///
/// Bars show one standard deviation.
pub fn drawn(summary: &Summary) -> String {
    let across = Axis::named(&PARAMETERS);
    let panel = |name: &str, level: f64, of: &dyn Fn(&Row) -> Mean| {
        let dots = LOSSES.into_iter().enumerate().map(|(k, loss)| {
            let rows = summary.rows.iter().filter(|row| row.loss == loss);
            let figures: Vec<Mean> = rows.map(of).collect();
            // The losses are drawn side by side over the name of their parameter.
            let place = |i: usize| i as f64 + 1.0 + 0.16 * (k as f64 - 0.5);
            let points = figures.iter().enumerate().map(|(i, f)| [place(i), f.value]);
            let intervals = figures
                .iter()
                .map(|f| [f.value - f.error, f.value + f.error]);
            let stroke = Stroke::solid(colour(loss));
            Curve::new(loss.name(), stroke, Marks::Dots, points).within(intervals)
        });
        let mut curves: Vec<Curve> = dots.collect();
        let ends = curves.iter().flat_map(|c| c.intervals.iter().flatten());
        let upward = Axis::around(ends.copied().chain([level]));
        let level = across.ends().map(|x| [x, level]);
        curves.push(Curve::limit("", Dash::Dashed, level));
        Facet::new("", [across, upward], ["", name], curves)
    };
    let panels = vec![
        panel("RMSE / Cramer-Rao bound", 1.0, &|row| row.rmse_over_bound),
        panel("coverage of 95 % intervals (%)", 95.0, &|row| Mean {
            value: 100.0 * row.coverage.value,
            error: 100.0 * row.coverage.error,
        }),
    ];
    let title = format!(
        "{} campaigns counted of {}",
        summary.counted, summary.campaigns
    );
    Figure::new(title, panels, 2).svg()
}

/// Draws the standard error over the bound against the seconds of the fit as SVG, for every fit of
/// the chosen kernel.
pub fn photographs(study: &Study) -> String {
    let fits = study.fits.iter();
    let fits = fits.filter_map(|fit| Some((fit.loss, [fit.seconds, fit.error_over_bound?])));
    let dots = fits.map(|(loss, point)| {
        let stroke = Stroke::solid(colour(loss));
        Curve::new(loss.name(), stroke, Marks::Dots, [point])
    });
    let mut curves: Vec<Curve> = dots.collect();
    let largest = |k: usize| {
        let values = curves.iter().flat_map(|c| &c.points).map(|point| point[k]);
        values.filter(|v| v.is_finite()).fold(0.0, f64::max)
    };
    let axes = [
        Axis::linear(0.0, 1.08 * largest(0)),
        Axis::linear(0.0, 1.08 * largest(1).max(1.0)),
    ];
    let level = axes[0].ends().map(|x| [x, 1.0]);
    curves.push(Curve::limit("", Dash::Dashed, level));
    let names = ["seconds of the fit", "standard error / Cramer-Rao bound"];
    let title = format!(
        "{} photographs, kernel {}",
        study.photographs,
        study.kernel.name()
    );
    Figure::new(title, vec![Facet::new("", axes, names, curves)], 1).svg()
}

/// Draws the errors of the forward models against samples per pixel and against seconds as SVG,
/// with logarithmic axes.
pub fn speed(speed: &Speed) -> String {
    let by_samples = errors(speed, |row| row.samples as f64);
    let by_seconds = errors(speed, |row| row.seconds);
    let names = ["samples per pixel", "seconds for the estimate"];
    let about = "error against the closed form (%)";
    let noise = speed.pixel_noise.c.map(|noise| 100.0 * noise);
    let closed = speed.spectral_seconds;
    let panels =
        [
            ("error and samples", by_samples, names[0], None),
            ("error and time", by_seconds, names[1], Some(closed)),
        ]
        .map(|(head, mut curves, name, upright)| {
            let values = |k: usize| {
                let points = curves.iter().flat_map(|c| &c.points);
                points.map(|point| point[k]).collect::<Vec<f64>>()
            };
            let axes = [
                Axis::decades(values(0).into_iter().chain(upright)),
                Axis::decades(values(1).into_iter().chain(noise)),
            ];
            let [x, y] = axes.map(|axis| axis.ends());
            curves.extend(noise.map(|noise| {
                Curve::limit("standard error of c", Dash::Dotted, x.map(|x| [x, noise]))
            }));
            curves.extend(upright.map(|at| {
                let name = "closed form, no sampling error";
                Curve::limit(name, Dash::Dashdot, y.map(|y| [at, y]))
            }));
            Facet::new(head, axes, [name, about], curves)
        });
    let title = format!("{} photographs: error by the samples", speed.photographs);
    Figure::new(title, panels.into(), 2).svg()
}

/// Name of a parameter, and a function that returns its error.
type Named = (&'static str, Dash, fn(&Render) -> Option<f64>);

/// Parameters whose errors are drawn.
const ERRORS: [Named; 2] = [
    ("c", Dash::Solid, |row| row.errors.c),
    ("a", Dash::Dashed, |row| row.errors.a),
];

/// Returns one curve per sequence and parameter against the variable `x`.
fn errors(speed: &Speed, x: impl Fn(&Render) -> f64) -> Vec<Curve> {
    let mut curves = Vec::new();
    for (sequence, hue) in [(Sequence::Sobol, HUES[1]), (Sequence::Independent, HUES[0])] {
        for (name, dash, error) in ERRORS {
            let rows = speed.rows.iter().filter(|row| row.sequence == sequence);
            let points = rows.filter_map(|row| Some([x(row), 100.0 * error(row)?]));
            // Logarithmic axes have no place for 0.
            let points = points.filter(|[x, y]| *x > 0.0 && *y > 0.0 && y.is_finite());
            let stroke = Stroke {
                colour: hue.into(),
                dash,
            };
            let name = format!("{name}, {}", sequence.name());
            curves.push(Curve::new(name, stroke, Marks::Both, points));
        }
    }
    curves.retain(|curve| !curve.points.is_empty());
    curves
}
