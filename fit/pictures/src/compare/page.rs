//! The comparison on one page of HTML: a screen with the picture through each sheet, the numbers
//! below it, and two charts.
//!
//! The page needs neither network nor script. Its menu of sheets and incidences is a form, whose
//! state the style sheet follows. It is well-formed XML too.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest, Sha256};

use crate::compare::comparison::{Compared, Comparison};
use crate::compare::gallery::{Gallery, Shown};
use crate::compare::text::{letter, lit, number, plain, ranges};
use crate::report::page::STYLE;
use crate::report::page::markup::{Row, significant, table};
use charts::{Axis, Dash, HUES, Panel, escape, svg};
use estimator::predict::Legibility;
use estimator::result::Number;

/// Style of the comparison, behind those of charts and of the report.
const OWN_STYLE: &str = include_str!("page/style.css");

/// Writes the page.
pub fn page(comparison: &Comparison, gallery: Option<&Gallery>, command: &str) -> String {
    let sheets = &comparison.sheets;
    let incidences = &comparison.conditions.incidence_deg;
    let style = format!(
        "\n{}{STYLE}{OWN_STYLE}{}",
        charts::STYLE,
        followed(sheets.len(), incidences.len())
    );
    let exposure = gallery.map_or(String::new(), |gallery| {
        format!(
            ". Mid-air images are shown {} times as bright as they are",
            significant(gallery.exposure, 3)
        )
    });
    let mut body = menu(comparison);
    for k in 0..incidences.len() {
        let shown = gallery.map(|gallery| (gallery, &gallery.shown[k][..]));
        body.push_str(&numbers(comparison, k, shown));
    }
    body.push_str(&readable(comparison));
    body.push_str(&charts_of(comparison));
    body.push_str(&notes(comparison, command));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
         style-src 'sha256-{}'; img-src data:; base-uri 'none'; form-action 'none'\"/>\n\
         <meta name=\"generator\" content=\"fit {}\"/>\n\
         <title>Sheets compared</title>\n<style>{style}</style>\n</head>\n<body>\n<header>\n\
         <h1>Which sheet?</h1>\n<p class=\"from\">{}</p>\n</header>\n<main>\n{body}</main>\n\
         </body>\n</html>\n",
        STANDARD.encode(Sha256::digest(&style)),
        env!("CARGO_PKG_VERSION"),
        escape(&(comparison.words() + &exposure)),
    )
}

/// Returns the rules by which the page follows its menu: what is not chosen is not shown.
fn followed(sheets: usize, incidences: usize) -> String {
    let mut rules = String::new();
    let mut follow = |id: String| {
        let _ = writeln!(
            rules,
            "body:has(#{id}:not(:checked)) .{id} {{ display: none; }}"
        );
    };
    (0..sheets).for_each(|k| follow(format!("s{k}")));
    (0..incidences).for_each(|k| follow(format!("i{k}")));
    for (k, hue) in (0..sheets).map(|k| (k, HUES[k % HUES.len()])) {
        let _ = writeln!(rules, ".own.s{k}, .key{k} {{ --line: {hue}; }}");
    }
    rules
}

/// Returns the class of the line of a sheet, which tells sheets of one hue apart.
fn dash(sheet: usize) -> &'static str {
    match Dash::ALL[sheet % Dash::ALL.len()] {
        Dash::Solid => "solid",
        Dash::Dashed => "dashed",
        Dash::Dotted => "dotted",
        Dash::Dashdot => "dashdot",
    }
}

/// Writes the menu of sheets, which is the legend of the charts too, and that of incidences.
fn menu(comparison: &Comparison) -> String {
    let mut out = String::from("<fieldset class=\"menu\"><legend>Sheets</legend>\n");
    for (k, sheet) in comparison.sheets.iter().enumerate() {
        let _ = writeln!(
            out,
            "<label class=\"key{k}\"><input type=\"checkbox\" id=\"s{k}\" checked=\"\"/> <svg \
             viewBox=\"0 0 32 12\" aria-hidden=\"true\"><path class=\"{}\" d=\"M2 6H30\"/></svg> \
             {}</label>",
            dash(k),
            escape(&sheet.name)
        );
    }
    out.push_str("</fieldset>\n");
    let incidences = &comparison.conditions.incidence_deg;
    if incidences.len() == 1 {
        let deg = plain(incidences[0]);
        let _ = writeln!(
            out,
            "<p class=\"menu\">Incidence {deg}\u{b0}<input type=\"radio\" id=\"i0\" checked=\"\" \
             hidden=\"\"/></p>"
        );
        return out;
    }
    out.push_str("<fieldset class=\"menu\"><legend>Incidence</legend>\n");
    for (k, deg) in incidences.iter().enumerate() {
        let checked = if k == 0 { " checked=\"\"" } else { "" };
        let deg = plain(*deg);
        let _ = writeln!(
            out,
            "<label><input type=\"radio\" name=\"incidence\" id=\"i{k}\"{checked}/> \
             {deg}\u{b0}</label>"
        );
    }
    out.push_str("</fieldset>\n");
    out
}

/// Writes a number, and below it how it compares with the first sheet.
fn cell(own: String, ratio: Option<Number>) -> String {
    let ratio = ratio.filter(|ratio| ratio.value.is_some());
    let small = ratio.map_or(String::new(), |ratio| {
        format!("<small>\u{d7} {}</small>", number(ratio, 1.0))
    });
    format!("{own}{small}")
}

/// Writes the row of the pictures at one incidence: the source, then the image through each sheet.
fn images_of(comparison: &Comparison, gallery: &Gallery, images: &[Shown], deg: &str) -> String {
    let mut out = String::new();
    let picture = |png: &[u8], what: &str| {
        format!(
            "<img alt=\"{}\" src=\"data:image/png;base64,{}\"/>",
            escape(what),
            STANDARD.encode(png)
        )
    };
    let _ = write!(
        out,
        "<tr><th scope=\"row\">{}Source, {} mm</th>",
        picture(&gallery.source, "Source"),
        significant(gallery.width_mm, 3)
    );
    for (s, (image, sheet)) in images.iter().zip(&comparison.sheets).enumerate() {
        let unknown = match image.is_unknown {
            true => "<small>mu is not known: as bright as the source</small>",
            false => "",
        };
        let what = format!("Mid-air image by {}, incidence {deg} degrees", sheet.name);
        let _ = write!(
            out,
            "<td class=\"s{s}\">{}{unknown}</td>",
            picture(&image.png, &what)
        );
    }
    out.push_str("</tr>\n");
    out
}

/// Writes the table of one incidence: a column per sheet, with its picture at the top.
fn numbers(comparison: &Comparison, k: usize, shown: Option<(&Gallery, &[Shown])>) -> String {
    let (unit, factor) = comparison.conditions.luminances();
    let ambient = comparison.conditions.viewing.ambient;
    let deg = plain(comparison.conditions.incidence_deg[k]);
    let mut out = format!(
        "<div class=\"scroll i{k}\" role=\"region\" tabindex=\"0\" aria-label=\"Incidence \
         {deg} degrees\"><table>\n<thead><tr><th scope=\"col\">Incidence {deg}\u{b0}</th>"
    );
    for (s, sheet) in comparison.sheets.iter().enumerate() {
        let _ = write!(
            out,
            "<th scope=\"col\" class=\"s{s}\">{}</th>",
            escape(&sheet.name)
        );
    }
    out.push_str("</tr></thead>\n<tbody>\n");
    if let Some((gallery, images)) = shown {
        out.push_str(&images_of(comparison, gallery, images, &deg));
    }
    let mut row = |head: &str, of: &dyn Fn(&Compared) -> String| {
        let _ = write!(out, "<tr><th scope=\"row\">{head}</th>");
        for (s, sheet) in comparison.sheets.iter().enumerate() {
            let _ = write!(out, "<td class=\"s{s}\">{}</td>", of(sheet));
        }
        out.push_str("</tr>\n");
    };
    row(&format!("Luminance of white ({unit})"), &|own| {
        let ratio = own.ratio.get(k).map(|ratio| ratio.luminance);
        cell(number(own.at[k].luminance, factor), ratio)
    });
    if ambient > 0.0 {
        row("with the ambient light", &|own| {
            number(lit(&own.at[k], ambient), factor)
        });
        row("Contrast in the ambient light", &|own| {
            number(own.at[k].contrast, 1.0)
        });
        row("Smallest readable letter (mm)", &|own| {
            let ratio = own.ratio.get(k).map(|ratio| ratio.letter);
            cell(letter(own.at[k].letter), ratio)
        });
    }
    row("Smallest readable letter in the dark (mm)", &|own| {
        let ratio = own.ratio.get(k).map(|ratio| ratio.letter_in_the_dark);
        cell(letter(Some(own.at[k].letter_in_the_dark)), ratio)
    });
    if let Some(range) = comparison.range() {
        row(
            &format!("Smallest letter readable at {range} (mm)"),
            &|own| own.everywhere_in_words(),
        );
    }
    row("MTF50 (1/mm)", &|own| {
        let ratio = own.ratio.get(k).map(|ratio| ratio.mtf50_per_mm);
        cell(number(own.at[k].mtf50_per_mm, 1.0), ratio)
    });
    out.push_str("</tbody></table></div>\n");
    out
}

/// Writes in which range of incidence the letters that were asked for are readable.
fn readable(comparison: &Comparison) -> String {
    let Some(letter_mm) = comparison.conditions.letter_mm else {
        return String::new();
    };
    let all = comparison.sheets.iter().enumerate().map(|(s, sheet)| {
        let found = sheet.readable_deg.as_deref().unwrap_or_default();
        format!(
            "<span class=\"s{s}\"><b>{}</b> {}. </span>",
            escape(&sheet.name),
            ranges(found).replace(" deg", "\u{b0}")
        )
    });
    format!(
        "<p>Capital letters of {letter_mm} mm are readable at these incidences: {}</p>\n",
        all.collect::<String>()
    )
}

/// Draws luminance and smallest letter against the incidence. The menu is their legend.
fn charts_of(comparison: &Comparison) -> String {
    let (unit, factor) = comparison.conditions.luminances();
    let luminance = |at: &Legibility| at.luminance.value.map(|light| light * factor);
    let height = |at: &Legibility| at.letter.and_then(|own| own.height_mm.value);
    let ambient = comparison.conditions.viewing.ambient > 0.0;
    let in_light = if ambient { " in the ambient light" } else { "" };
    let first = chart(
        comparison,
        "luminance",
        &format!("Luminance of white ({unit}) against the incidence (\u{b0})"),
        &luminance,
        false,
    );
    let second = chart(
        comparison,
        "letter (mm)",
        &format!("Smallest readable letter{in_light} (mm) against the incidence (\u{b0})"),
        &height,
        true,
    );
    format!("<div class=\"charts\">\n{first}{second}</div>\n")
}

/// Draws a number of all sheets against the incidence, on a logarithmic axis if it is `wide`.
fn chart(
    comparison: &Comparison,
    name: &str,
    caption: &str,
    of: &dyn Fn(&Legibility) -> Option<f64>,
    wide: bool,
) -> String {
    let curves = || comparison.sheets.iter().flat_map(|sheet| &sheet.curve);
    let values: Vec<f64> = curves().filter_map(of).collect();
    let last = curves().map(|at| at.incidence_deg).fold(0.0, f64::max);
    let most = values.iter().copied().fold(0.0, f64::max);
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    // Letters grow without end where the image fades; beyond a hundred times the least they are
    // no letters of a sign.
    let y = match wide {
        true if least.is_finite() => Axis::logarithmic(0.9 * least, most.min(100.0 * least)),
        _ => Axis::linear(0.0, 1.05 * most),
    };
    let panel = Panel {
        x: Axis::linear(0.0, last),
        y,
        frame: [52.0, 8.0, 324.0, 150.0],
    };
    let mut body = panel.grid(5, true) + &panel.names("incidence (\u{b0})", name);
    for (s, sheet) in comparison.sheets.iter().enumerate() {
        let point = |at: &Legibility| [at.incidence_deg, of(at).unwrap_or(f64::NAN)];
        let line: Vec<[f64; 2]> = sheet.curve.iter().map(point).collect();
        let dots: Vec<[f64; 2]> = sheet.at.iter().map(point).collect();
        let _ = write!(
            body,
            "<g class=\"own s{s}\">{}{}</g>",
            panel.line(dash(s), &line),
            panel.dots("dots", &dots)
        );
    }
    format!(
        "<figure>{}<figcaption>{}</figcaption></figure>\n",
        svg([384.0, 200.0], caption, &body),
        escape(caption)
    )
}

/// Writes agreement, criterion, warnings and the command, folded.
fn notes(comparison: &Comparison, command: &str) -> String {
    let mut out = String::new();
    if !comparison.agreement.is_empty() {
        let rows = comparison.agreement.iter().map(|own| {
            let cells = vec![
                escape(&own.parameter.to_string()),
                own.results.to_string(),
                number(own.mean, 1.0),
                significant(own.chi2, 3),
                own.degrees_of_freedom.to_string(),
                significant(own.p_value, 2),
            ];
            Row::from(cells)
        });
        let head = [
            "parameter",
            "results",
            "mean",
            "\u{3c7}\u{b2}",
            "degrees of freedom",
            "probability",
        ];
        let _ = write!(
            out,
            "<details class=\"notes\"><summary><h2>Do the results agree?</h2></summary>\n<p>These \
             results have the same cell and kernel. If they are of one sheet, noise alone scatters \
             them so far or farther with this probability.</p>\n{}</details>\n",
            table("Agreement of results", &head, &rows.collect::<Vec<_>>())
        );
    }
    let criterion = comparison.criterion;
    let _ = write!(
        out,
        "<details class=\"notes\"><summary><h2>What the numbers mean</h2></summary>\n<p>Luminance \
         is that of white, through half mirror and sheet. The contrast is that of a wide pattern, \
         (Lmax \u{2212} Lmin) / (Lmax + Lmin), whose dark is the ambient light. A capital letter is \
         readable if its strokes, {} periods within its height, keep a contrast of {} along and \
         across the plane of incidence: people then read letters of 0.25 to 2 degrees with at least \
         half of their speed (Legge, Rubin and Luebker, Vision Research 27, 1165, 1987). It is at \
         least {} minutes of arc high for the viewer, here {} mm (ISO 8596). Easy reading needs \
         letters three times as high. MTF50 is the frequency at which the lesser of both MTFs \
         falls to one half. Small numbers are ratios to the first sheet; \u{b1} is one standard \
         error, as far as a fit gives it.</p>\n</details>\n",
        criterion.periods,
        criterion.contrast,
        criterion.arcminutes,
        significant(comparison.eye_mm, 3)
    );
    let texts = comparison.assumptions.iter().chain(&comparison.warnings);
    let warnings: String = texts
        .map(|warning| format!("<li>{}</li>\n", escape(warning)))
        .collect();
    let _ = write!(
        out,
        "<details class=\"notes\"><summary><h2>Warnings and assumptions</h2></summary>\n<ul>\n\
         {warnings}</ul>\n<p>Made by <code>{}</code></p>\n</details>\n",
        escape(command)
    );
    out
}
