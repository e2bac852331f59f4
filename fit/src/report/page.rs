//! HTML page of `--report`: the page that a person opens first.
//!
//! The page is one file that needs nothing else, neither network nor script. It is well-formed XML
//! too. The same estimate gives the same bytes, because the page holds no times and no durations.

mod chart;
mod crop;
mod curves;
mod estimates;
pub(crate) mod evidence;
mod identify;
mod markup;
mod photographs;
mod provenance;
pub(crate) mod shown;
mod terms;
mod trust;

use crate::estimate::Verdict;
use crate::report::page::markup::{count, escape, significant};
use crate::report::page::shown::Page;
use crate::result::FitResult;

/// Style sheet of the page.
const STYLE: &str = include_str!("page/style.css");

/// One section of the page: its anchor, its heading, its markup.
type Section = (&'static str, &'static str, String);

impl Page<'_> {
    /// Writes the page as HTML.
    pub(crate) fn html(&self) -> String {
        let title = format!("Estimate of {}", self.campaign.file.display());
        let sections: [Section; 6] = [
            ("estimates", "Estimates", estimates::section(self)),
            (
                "curves",
                "Sharpness, measured and modelled",
                curves::section(self),
            ),
            ("terms", "Choice of the model", terms::section(self)),
            (
                "told",
                "How sure the estimates are",
                identify::section(self),
            ),
            ("warnings", "Warnings", photographs::section(self)),
            (
                "provenance",
                "Where the numbers come from",
                provenance::section(self),
            ),
        ];
        let mut body = String::new();
        let mut contents = String::new();
        for (anchor, heading, markup) in sections {
            contents.push_str(&format!("<a href=\"#{anchor}\">{heading}</a>\n"));
            body.push_str(&format!(
                "<section id=\"{anchor}\" aria-labelledby=\"{anchor}-h\">\n<h2 \
                id=\"{anchor}-h\">{heading}</h2>\n{markup}</section>\n"
            ));
        }
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
             <meta name=\"generator\" content=\"fit {}\"/>\n\
             <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
             <header>\n<p class=\"kicker\">Retroreflective sheet</p>\n<h1>{}</h1>\n<p \
             class=\"from\">{title}</p>\n{}</header>\n\
             <nav aria-label=\"Contents\">\n{contents}</nav>\n<main>\n{body}</main>\n</body>\n\
             </html>\n",
            env!("CARGO_PKG_VERSION"),
            escape(&self.result.table.design),
            self.verdict(),
            title = escape(&title),
        )
    }

    /// Writes the summary: the photographs, the model, and whether the model describes them.
    fn verdict(&self) -> String {
        let result = self.result;
        let distinct = |of: fn(&crate::result::CaptureResult) -> f64| {
            let mut values: Vec<f64> = result.captures.iter().map(of).collect();
            values.sort_by(f64::total_cmp);
            values.dedup();
            values.len()
        };
        let warnings = photographs::number(result);
        let mut text = format!(
            "<p>This page shows what <code>fit</code> found out about a retroreflective sheet: a \
             sheet of small corner cubes (each three mirrors at right angles) that sends light \
             back the way it came. <code>fit</code> used {} of straight edges between dark and \
             bright, at {} and {}. The incidence angle is the angle between the light and the \
             normal of the sheet, a line at right angles to the sheet. The floating distance is \
             the length of the way of the light from the sheet to the mid-air image.</p>\n\
             <p>{}</p>\n",
            count(result.captures.len(), "photograph", "photographs"),
            count(
                distinct(|c| c.incidence_deg),
                "incidence angle",
                "incidence angles"
            ),
            count(
                distinct(|c| c.floating_distance_mm),
                "floating distance",
                "floating distances"
            ),
            terms::explained(result.kernel, result.lobe),
        );
        text.push_str(&result.fit.as_ref().map_or(String::new(), quality));
        if warnings > 0 {
            text.push_str(&format!(
                "<p class=\"warned\">Read the <a href=\"#warnings\">{}</a> before you use the \
                 numbers.</p>\n",
                count(warnings, "warning", "warnings")
            ));
        }
        text.push_str(
            "<p>Each word is explained where it first stands on this page. All words and formulas \
             are in the file <code>fit/doc/model.md</code> of the project.</p>\n",
        );
        text
    }
}

/// Writes how well the model describes the photographs.
fn quality(fit: &FitResult) -> String {
    let says = match fit.verdict {
        Verdict::Good => "describes the photographs within their noise",
        Verdict::Strained => {
            "describes the photographs, but noise does not explain all of the rest"
        }
        Verdict::Poor => "does not describe the photographs",
    };
    let raised = if fit.scale > 1.0 {
        format!(
            " All standard errors are multiplied by {} for this.",
            significant(fit.scale, 3)
        )
    } else {
        String::new()
    };
    format!(
        "<p>The fit is <strong class=\"{verdict}\">{verdict}</strong>: the model {says}. \
         Chi-square (\u{3c7}\u{b2}) is {} per degree of freedom. Chi-square is the sum of the \
         squared differences between photographs and model, in units of their noise. \
         \u{201c}Per degree of freedom\u{201d} means: divided by the number of data minus the \
         number of fitted parameters. A value near 1 says that only noise is left. Noise alone \
         gives this value or a larger one with a probability of {}.{raised}</p>\n",
        significant(fit.reduced_chi2, 4),
        significant(fit.p_value, 2),
        verdict = fit.verdict.name(),
    )
}
