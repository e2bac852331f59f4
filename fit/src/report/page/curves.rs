//! Small multiples: the MTF of every photograph, measured and modelled through one estimator, and
//! what lies between.

use crate::result::CaptureResult;

use crate::report::page::chart::{Axis, Panel, svg};
use crate::report::page::markup::{escape, significant};
use crate::report::page::shown::Page;

/// Modulus below which nothing is to be seen.
const VISIBLE: f64 = 0.02;

/// Standard errors that a good residual seldom leaves; a worse one widens the strip.
const RESIDUALS: f64 = 4.0;

/// One figure per photograph, all with the same axes.
pub(crate) fn section(page: &Page) -> String {
    let captures = &page.result.captures;
    let farthest = captures
        .iter()
        .flat_map(|c| c.curves.frequency_per_mm.iter().zip(&c.curves.measured))
        .filter(|(_, m)| **m > VISIBLE)
        .map(|(&f, _)| f)
        .fold(0.0, f64::max);
    let figures: String = captures.iter().map(|c| figure(c, farthest)).collect();
    format!(
        "<p>The spectrum of every edge along its normal: <span class=\"key measured\">dots</span> \
        are the photograph with \
         95 % intervals, the <span class=\"key model\">line</span> is the fitted model seen \
         through the same window, bins and \
         taper. Below each, their difference in standard errors; the band holds 95 % of pure \
         noise. Neighbouring \
         frequencies share pixels, so their differences run together.</p>\n<div \
         class=\"grid\">\n{figures}</div>\n"
    )
}

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
        frame: [36.0, 6.0, 276.0, 140.0],
    };
    let intervals: Vec<(f64, [f64; 2])> = at(&curves.measured)
        .into_iter()
        .zip(&curves.standard_error)
        .map(|([f, m], e)| {
            let half = crate::report::page::estimates::INTERVAL * e;
            (f, [(m - half).max(0.0), (m + half).min(1.05)])
        })
        .collect();
    // The modulus at zero frequency is 1 by definition.
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
        frame: [36.0, 156.0, 276.0, 46.0],
    };
    let band = crate::report::page::estimates::INTERVAL;
    let body = [
        main.grid(4, false),
        main.names("", "MTF"),
        main.bars("error", &intervals),
        main.line("model", &at(&curves.modelled)),
        main.dots("measured", &at(&curves.measured)),
        strip.band("noise", -band, band),
        strip.grid(2, true),
        strip.names("frequency (1/mm)", "diff./s.e."),
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
        svg([320.0, 236.0], &label, &body),
        capture.incidence_deg,
        capture.floating_distance_mm,
        capture.edge_angle_deg,
        significant(rms, 2),
        escape(&capture.image)
    )
}
