//! `--report`: the page that a person opens first. One file that needs nothing else, no network and
//! no script; it is well-formed XML too. The same estimate gives the same bytes: no times, no
//! durations.

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

use crate::report::page::markup::{count, escape, significant};
use crate::report::page::shown::Page;

const STYLE: &str = include_str!("page/style.css");

/// One section: its anchor, its heading, its markup.
type Section = (&'static str, &'static str, String);

impl Page<'_> {
    /// The page as HTML.
    pub(crate) fn html(&self) -> String {
        let title = format!("Estimate of {}", self.campaign.file.display());
        let sections: [Section; 6] = [
            ("estimates", "Estimates", estimates::section(self)),
            (
                "curves",
                "MTF, measured and modelled",
                curves::section(self),
            ),
            ("terms", "Terms of the model", terms::section(self)),
            (
                "told",
                "What the photographs can tell",
                identify::section(self),
            ),
            ("warnings", "Warnings", photographs::section(self)),
            ("provenance", "Provenance", provenance::section(self)),
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
             <nav aria-label=\"Contents\">\n{contents}</nav>\n<main>\n{body}</main>\n</body>\n</html>\n",
            env!("CARGO_PKG_VERSION"),
            escape(&self.result.table.design),
            self.verdict(),
            title = escape(&title),
        )
    }

    /// In two sentences: what was fitted, and whether it may be believed.
    fn verdict(&self) -> String {
        let result = self.result;
        let distinct = |of: fn(&crate::result::CaptureResult) -> f64| {
            let mut values: Vec<f64> = result.captures.iter().map(of).collect();
            values.sort_by(f64::total_cmp);
            values.dedup();
            values.len()
        };
        let warnings = photographs::number(result);
        let (class, fits) = if self.evidence.reduced_chi2 > crate::estimate::POOR_FIT {
            ("poor", "does not describe them within their noise")
        } else {
            ("good", "describes them within their noise")
        };
        let mut text = format!(
            "<p>{} at {} and {}. The model, {}, <strong class=\"{class}\">{fits}</strong>: \
             \u{3c7}\u{b2}\u{a0}{} per degree of freedom, where 1 is pure pixel noise.</p>\n",
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
            terms::in_words(result.kernel, result.lobe),
            significant(self.evidence.reduced_chi2, 3),
        );
        if warnings > 0 {
            text.push_str(&format!(
                "<p class=\"warned\"><a href=\"#warnings\">{}</a> to read before the numbers are \
                used.</p>\n",
                count(warnings, "warning", "warnings")
            ));
        }
        text
    }
}
