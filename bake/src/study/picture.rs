//! Picture of a study: error against rays and against seconds, on logarithmic axes.

use crate::rays::Tracer;
use crate::study::report::{slope_text, title};
use crate::study::study::{Reference, Series, Study, StudyPoint};
use charts::{Axis, Curve, Dash, Facet, Figure, HUES, Marks, Stroke};
use tables::options::Sampler;

/// Draws the study as SVG.
pub(crate) fn draw(study: &Study) -> String {
    let exact = match study.reference {
        Reference::Exact { seconds } => Some(seconds),
        Reference::Sobol { .. } => None,
    };
    let names = ["rays per direction", "L1 error, mean over directions"];
    let by_rays = facet(
        study,
        "error and rays",
        names,
        |p| [p.rays as f64, p.l1],
        None,
    );
    let names = ["seconds for all directions", "L1 error, worst direction"];
    let mut by_seconds = facet(
        study,
        "error and time",
        names,
        |p| [p.seconds, p.worst_l1],
        exact,
    );
    let [x, y] = by_seconds.axes.map(|axis| axis.ends());
    let target = study.target;
    let level = x.map(|x| [x, target]);
    by_seconds
        .curves
        .push(Curve::limit(format!("L1 = {target}"), Dash::Dotted, level));
    if let Some(seconds) = exact {
        let name = format!("exact: {:.2} ms, no sampling error", 1e3 * seconds);
        let upright = y.map(|y| [seconds, y]);
        by_seconds
            .curves
            .push(Curve::limit(name, Dash::Dashdot, upright));
    }
    let title = format!(
        "{}: {} directions, {} x {} bins; L1 error per launched ray",
        study.design, study.directions, study.bins, study.bins
    );
    Figure::new(title, vec![by_rays, by_seconds], 2).svg()
}

/// Draws all series, with hues by sampler, dashed if rays are traced one by one; the axis to the
/// right holds `also` too.
fn facet(
    study: &Study,
    head: &str,
    names: [&str; 2],
    coordinates: fn(&StudyPoint) -> [f64; 2],
    also: Option<f64>,
) -> Facet {
    let curve = |series: &Series| {
        let hue = match series.sampler {
            Sampler::Random => HUES[0],
            Sampler::Sobol => HUES[1],
        };
        let stroke = Stroke {
            colour: hue.into(),
            dash: match series.tracer {
                Tracer::Fastest => Dash::Solid,
                Tracer::OneByOne => Dash::Dashed,
            },
        };
        let name = format!("{}: slope {}", title(series), slope_text(series));
        Curve::new(
            name,
            stroke,
            Marks::Both,
            series.points.iter().map(coordinates),
        )
    };
    let curves: Vec<Curve> = study.series.iter().map(curve).collect();
    let values = |k: usize| {
        curves
            .iter()
            .flat_map(move |c| c.points.iter().map(move |p| p[k]))
    };
    let axes = [
        Axis::decades(values(0).chain(also)),
        Axis::decades(values(1)),
    ];
    Facet::new(head, axes, names, curves)
}
