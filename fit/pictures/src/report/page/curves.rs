//! Section of the page with the MTF of every photograph, measured and modelled by the same
//! estimator, and their difference.

use estimator::result::CaptureResult;

use crate::report::page::markup::significant;
use crate::report::page::shown::Page;
use charts::{Axis, Panel, escape, svg};

/// MTF below which frequencies are not drawn.
const VISIBLE: f64 = 0.02;

/// Half height of the strip of residuals, standard errors; a larger residual makes the strip
/// higher.
const RESIDUALS: f64 = 4.0;

/// Left side of both panels: the name of the axis and numbers such as -2000 stand before it.
const LEFT: f64 = 52.0;

/// Writes one figure per photograph, all with the same axes.
pub(crate) fn section(page: &Page) -> String {
    let captures = &page.result.captures;
    let farthest = farthest(captures);
    let figures: String = captures.iter().map(|c| figure(c, farthest)).collect();
    format!(
        "<p>The modulation transfer function (MTF) says how much contrast the image keeps of a \
         pattern of lines: 1 is all of it, 0 is none. The frequency is the number of line pairs \
         (one dark, one bright) per millimetre. The MTF50 is the frequency at which the MTF falls \
         to one half; a larger MTF50 means a sharper image.</p>\n<p>Each picture stands for one \
         photograph. The <span class=\"key measured\">dots</span> are the photograph, with 95 % \
         intervals. The <span class=\"key model\">line</span> is the model, measured in the same \
         way as the photograph. The strip below shows the difference of the two, in standard \
         errors (\u{3c3}). If only noise is left, the shaded band holds 95 % of the dots. \
         Neighbouring dots share pixels, so their differences are alike.</p>\n<p>Below each \
         picture stand incidence, floating distance, the direction across the edge (0\u{b0} is \
         right, 90\u{b0} is down), MTF50, and the root mean square (rms) difference of the two \
         curves.</p>\n<div class=\"grid\">\n{figures}</div>\n"
    )
}

/// Returns the highest frequency at which a measured MTF is seen.
pub(crate) fn farthest(captures: &[CaptureResult]) -> f64 {
    captures
        .iter()
        .flat_map(|c| c.curves.frequency_per_mm.iter().zip(&c.curves.measured))
        .filter(|(_, m)| **m > VISIBLE)
        .map(|(&f, _)| f)
        .fold(0.0, f64::max)
}

/// Draws the MTF curves and residuals of one photograph.
fn figure(capture: &CaptureResult, farthest: f64) -> String {
    let curves = &capture.curves;
    let shown = curves
        .frequency_per_mm
        .iter()
        .take_while(|&&f| f <= farthest)
        .count();
    let at = |y: &[f64]| -> Vec<[f64; 2]> {
        let points = curves.frequency_per_mm[..shown].iter().zip(y);
        points.map(|(&f, &m)| [f, m]).collect()
    };
    let x = Axis::linear(0.0, farthest);
    let main = Panel {
        x,
        y: Axis::linear(0.0, 1.05),
        frame: [LEFT, 6.0, 312.0 - LEFT, 140.0],
    };
    let intervals: Vec<(f64, [f64; 2])> = at(&curves.measured)
        .into_iter()
        .zip(&curves.standard_error)
        .map(|([f, m], e)| {
            let half = crate::report::page::estimates::INTERVAL * e;
            (f, [(m - half).max(0.0), (m + half).min(1.05)])
        })
        .collect();
    // The MTF at frequency 0 is 1 by definition, so it has no residual.
    let residuals: Vec<[f64; 2]> = at(&curves.measured)
        .into_iter()
        .zip(curves.modelled.iter().zip(&curves.standard_error))
        .skip(1)
        .map(|([f, measured], (modelled, e))| [f, (measured - modelled) / e])
        .collect();
    let largest = residuals
        .iter()
        .map(|r| r[1].abs())
        .fold(RESIDUALS, f64::max);
    let strip = Panel {
        x,
        y: Axis::linear(-1.05 * largest, 1.05 * largest),
        frame: [LEFT, 156.0, 312.0 - LEFT, 66.0],
    };
    let band = crate::report::page::estimates::INTERVAL;
    let body = [
        main.grid(4, false),
        main.names("", "MTF"),
        main.bars("error", &intervals),
        main.line("model", &at(&curves.modelled)),
        main.dots("measured", &at(&curves.measured)),
        strip.band("noise", -band, band),
        strip.grid(5, true),
        strip.names("frequency (1/mm)", "residual (\u{3c3})"),
        strip.dots("measured", &residuals),
    ]
    .concat();
    let half = capture.mtf50_per_mm.map_or("not reached".into(), |f| {
        format!("{}/mm", significant(f, 4))
    });
    let rms = capture.loss.max(0.0).sqrt();
    let label = format!(
        "MTF of {}: measured and modelled; MTF50 {half}, root mean square difference {}",
        capture.image,
        significant(rms, 2)
    );
    format!(
        "<figure class=\"capture\">{}<figcaption><b>{}\u{b0}, {} mm</b>, edge \
        {:.1}\u{b0}<br/>MTF50 {half}, rms difference {}\
         <br/><code>{}</code></figcaption></figure>\n",
        svg([320.0, 256.0], &label, &body),
        capture.incidence_deg,
        capture.floating_distance_mm,
        capture.edge_angle_deg,
        significant(rms, 2),
        escape(&capture.image)
    )
}
