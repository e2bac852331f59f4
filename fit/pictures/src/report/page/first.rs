//! First screen of the page: the verdict, three numbers, a mid-air image, and all curves.

use crate::report::page::curves::farthest;
use crate::report::page::estimates;
use crate::report::page::markup::{count, significant};
use crate::report::page::photographs;
use crate::report::page::shown::Page;
use charts::{Axis, Panel, escape, svg};
use estimator::estimate::Verdict;
use estimator::result::{CaptureResult, FitResult};

/// Writes the first screen.
pub(crate) fn screen(page: &Page) -> String {
    let result = page.result;
    let mut out = result.fit.as_ref().map_or(String::new(), verdict);
    let warnings = photographs::number(result);
    if warnings > 0 {
        out.push_str(&format!(
            "<p class=\"warned\">Read the <a href=\"#warnings\">{}</a> before you use the \
             numbers.</p>\n",
            count(warnings, "warning", "warnings")
        ));
    }
    out.push_str(&estimates::brief(page));
    let pictures = crate::report::page::aerial::figures(page).unwrap_or_default();
    out.push_str(&format!(
        "<div class=\"first grid\">\n{pictures}{}</div>\n",
        overview(&result.captures)
    ));
    out
}

/// Returns what a verdict says, as a verb and its object.
pub(crate) const fn said(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Good => "describes the photographs within their noise",
        Verdict::Strained => {
            "describes the photographs, but noise does not explain all of the rest"
        }
        Verdict::Poor => "does not describe the photographs",
    }
}

/// Writes the verdict in one sentence, and the best suspect in another.
fn verdict(fit: &FitResult) -> String {
    let mu_alone = fit.verdict == Verdict::Strained && fit.scale <= 1.0;
    let said = if mu_alone {
        "describes the blur within its noise, but the photographs disagree on mu"
    } else {
        said(fit.verdict)
    };
    let suspect = match fit.suspects.first() {
        Some(first) if fit.verdict != Verdict::Good => {
            format!(" Perhaps {}.", escape(&first.what))
        }
        _ => String::new(),
    };
    format!(
        "<p class=\"verdict\">The fit is <strong class=\"{verdict}\">{verdict}</strong>: the model \
         {said}.{suspect}</p>\n",
        verdict = fit.verdict.name(),
    )
}

/// Draws the curves of all photographs in one panel.
fn overview(captures: &[CaptureResult]) -> String {
    let farthest = farthest(captures);
    let panel = Panel {
        x: Axis::linear(0.0, farthest),
        y: Axis::linear(0.0, 1.05),
        frame: [44.0, 8.0, 332.0, 240.0],
    };
    let mut body = panel.grid(5, true) + &panel.names("frequency (1/mm)", "MTF");
    let curve = |capture: &CaptureResult, y: &[f64]| -> Vec<[f64; 2]> {
        let points = capture.curves.frequency_per_mm.iter().zip(y);
        let points = points.map(|(&f, &m)| [f, m]);
        points.take_while(|point| point[0] <= farthest).collect()
    };
    for capture in captures {
        body.push_str(&panel.line("model thin", &curve(capture, &capture.curves.modelled)));
    }
    for capture in captures {
        body.push_str(&panel.dots("measured small", &curve(capture, &capture.curves.measured)));
    }
    let halves = captures.iter().filter_map(|capture| capture.mtf50_per_mm);
    let (low, high) = halves.fold((f64::INFINITY, 0.0_f64), |(l, h), f| (l.min(f), h.max(f)));
    let half = match low <= high {
        true => format!(
            " Half of the contrast is left at {} to {} line pairs per mm.",
            significant(low, 3),
            significant(high, 3)
        ),
        false => String::new(),
    };
    let label = "Contrast against fineness of all photographs, measured and modelled; each has a \
        picture of its own below";
    format!(
        "<figure>{}<figcaption><b>Sharpness</b> in {}: <span class=\"key measured\">dots</span> \
         measured, <span class=\"key model\">lines</span> modelled.{half}</figcaption></figure>\n",
        svg([384.0, 288.0], label, &body),
        count(captures.len(), "photograph", "photographs"),
    )
}
