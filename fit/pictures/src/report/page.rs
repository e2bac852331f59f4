//! HTML page of `--report`: the page that a person opens first.
//!
//! The page is one file that needs nothing else, neither network nor script, and its policy allows
//! a browser none of them. It is well-formed XML too. The same estimate gives the same bytes,
//! because the page holds no times and no durations.
//!
//! A first screen shows verdict, numbers, one mid-air image and the curves. All else folds out, on
//! paper by itself.

mod aerial;
mod crop;
mod curves;
mod estimates;
pub mod evidence;
mod first;
mod identify;
pub(crate) mod markup;
mod photographs;
mod provenance;
pub mod shown;
mod terms;
mod trust;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest, Sha256};

use crate::report::page::markup::{count, significant};
use crate::report::page::shown::Page;
use charts::escape;
use estimator::result::FitResult;

/// Style sheet of the page, but for that of its charts.
pub(crate) const STYLE: &str = include_str!("page/style.css");

/// One section of the page: its anchor, its heading, its markup.
type Section = (&'static str, &'static str, String);

impl Page<'_> {
    /// Writes the page as HTML.
    pub fn html(&self) -> String {
        let title = format!("Estimate of {}", self.campaign.file.display());
        let sections: [Section; 7] = [
            ("about", "What this page shows", self.about()),
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
            // The anchor is inside, so that a browser that follows it unfolds the section.
            body.push_str(&format!(
                "<section aria-labelledby=\"{anchor}-h\">\n<details><summary><h2 \
                id=\"{anchor}-h\">{heading}</h2></summary>\n<div \
                id=\"{anchor}\">\n{markup}</div></details></section>\n"
            ));
        }
        let style = format!("\n{}{STYLE}", charts::STYLE);
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
             style-src 'sha256-{}'; img-src data:; base-uri 'none'; form-action 'none'\"/>\n\
             <meta name=\"generator\" content=\"fit {}\"/>\n\
             <title>{title}</title>\n<style>{style}</style>\n</head>\n<body>\n\
             <header>\n<p class=\"kicker\">Retroreflective sheet</p>\n<h1>{}</h1>\n<p \
             class=\"from\">{title}</p>\n{}</header>\n\
             <nav aria-label=\"Contents\">\n{contents}</nav>\n<main>\n{body}</main>\n</body>\n\
             </html>\n",
            STANDARD.encode(Sha256::digest(&style)),
            env!("CARGO_PKG_VERSION"),
            escape(&self.result.table.design),
            first::screen(self),
            title = escape(&title),
        )
    }

    /// Writes what is known of the photographs, of the model, and of how well it describes them.
    fn about(&self) -> String {
        let result = self.result;
        let distinct = |of: fn(&estimator::result::CaptureResult) -> f64| {
            let mut values: Vec<f64> = result.captures.iter().map(of).collect();
            values.sort_by(f64::total_cmp);
            values.dedup();
            values.len()
        };
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
        text.push_str(
            "<p>Each word is explained where it first stands below. All words and formulas are in \
             the file <code>fit/doc/model.md</code> of the project.</p>\n",
        );
        text
    }
}

/// Writes how well the model describes the photographs.
fn quality(fit: &FitResult) -> String {
    let says = first::said(fit.verdict);
    let raised = if fit.scale > 1.0 {
        format!(
            " All standard errors are multiplied by {} for this.",
            significant(fit.scale, 3)
        )
    } else {
        String::new()
    };
    format!(
        "<p>The fit is {verdict}: the model {says}. \
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

#[cfg(test)]
mod tests {
    use super::STYLE;

    /// Pairs of text and ground that the page shows: names of colours in the style sheet.
    const PAIRS: [(&str, &[&str]); 6] = [
        ("ink", &["paper", "tint", "warn"]),
        ("soft", &["paper", "tint"]),
        ("measured", &["paper", "tint", "warn"]),
        ("model", &["paper"]),
        ("good", &["paper"]),
        ("poor", &["paper"]),
    ];

    /// Returns the relative luminance of a colour such as `#14181c`, as WCAG 2 defines it.
    fn luminance(colour: &str) -> f64 {
        let channel = |k: usize| {
            let value = u8::from_str_radix(&colour[k..k + 2], 16).expect("two digits");
            let value = f64::from(value) / 255.0;
            match value <= 0.04045 {
                true => value / 12.92,
                false => ((value + 0.055) / 1.055).powf(2.4),
            }
        };
        0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5)
    }

    #[test]
    fn charts_have_the_colours_of_plots_in_the_light_scheme() {
        let (light, _) = STYLE.split_once('}').expect("a block ends");
        for (name, colour) in charts::PALETTE {
            assert!(light.contains(&format!("--{name}: {colour};")), "{name}");
        }
    }

    /// Checks the contrast of all text in the light scheme, in the dark one, and on paper: at least
    /// 4.5 (WCAG 2.2, 1.4.3).
    #[test]
    fn all_text_has_contrast_in_every_scheme() {
        let schemes = STYLE.split(":root {").skip(1);
        let mut pairs = 0;
        for scheme in schemes {
            let scheme = scheme.split_once('}').expect("a block ends").0;
            let colour = |name: &str| {
                let start = format!("--{name}: ");
                let (_, rest) = scheme.split_once(&start).expect("every scheme has it");
                luminance(&rest[..7])
            };
            for (text, grounds) in PAIRS {
                for ground in grounds {
                    let (a, b) = (colour(text), colour(ground));
                    let contrast = (a.max(b) + 0.05) / (a.min(b) + 0.05);
                    assert!(contrast >= 4.5, "{text} on {ground}: {contrast}\n{scheme}");
                    pairs += 1;
                }
            }
        }
        assert_eq!(pairs, 3 * 11);
        println!("{pairs} pairs of colours");
    }
}
