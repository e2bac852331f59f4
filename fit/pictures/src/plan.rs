//! A planned campaign on one page to print: the photographs with boxes to tick, and what to expect.
//!
//! The page needs neither network nor script, and is well-formed XML too.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest, Sha256};

use crate::report::page::STYLE;
use crate::report::page::markup::{Row, table};
use charts::escape;
use lab::plan::{Apart, Expected, Photograph, Planned, Told, chi_square};

/// Style of the page, behind that of the report: rows to write on, and small headings.
const OWN_STYLE: &str = "h2 { display: block; margin: 1rem 0 0; font-size: 1.1rem; } \
    .scroll { margin: 0.25rem 0; } td { white-space: normal; } \
    main > .scroll:first-child td:last-child { min-width: 9rem; } \
    @media print { html { font-size: 8.5pt; } th, td { padding: 0.15rem 0.9rem 0.15rem 0; } }\n";

/// Writes the page of a plan.
pub fn page(planned: &Planned, title: &str, command: &str) -> String {
    let style = format!("\n{STYLE}{OWN_STYLE}");
    let count = planned.photographs.len();
    let mut body = photographs(planned) + &errors(planned);
    body.push_str(&kernels(planned));
    body.push_str(&further(planned));
    let warnings = planned.warnings.iter();
    let warnings = warnings.map(|own| format!("<p>{}.</p>\n", escape(own)));
    body.extend(warnings);
    body.push_str(&format!("<p>{}</p>\n", escape(&planned.conditions())));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
         style-src 'sha256-{}'; base-uri 'none'; form-action 'none'\"/>\n\
         <meta name=\"generator\" content=\"fit {}\"/>\n\
         <title>Photographs to take: {title}</title>\n<style>{style}</style>\n</head>\n<body>\n\
         <header>\n<h1>{count} photographs to take, and one of the source</h1>\n<p \
         class=\"from\">{title}</p>\n</header>\n<main>\n{body}<p><small>Made by \
         <code>{}</code></small></p>\n</main>\n</body>\n</html>\n",
        STANDARD.encode(Sha256::digest(&style)),
        env!("CARGO_PKG_VERSION"),
        escape(command),
        title = escape(title),
    )
}

/// Writes the photographs, each with a box to tick and a place for the exposure that was used.
fn photographs(planned: &Planned) -> String {
    let source = ["source.tif", "the source itself", "", "", "", "1"];
    let source = source.map(str::to_owned).to_vec();
    let own = (1..).zip(&planned.photographs).map(|(number, own)| {
        let mut cells = vec![format!("aerial_{number:02}.tif")];
        cells.extend(setup(own));
        cells.push(format!("{:.3}", own.exposure));
        cells
    });
    let rows = std::iter::once(source).chain(own).map(|cells| {
        let name = cells[0].clone();
        let mut row = vec![format!("<label><input type=\"checkbox\"/> {name}</label>")];
        row.extend(cells.into_iter().skip(1));
        row.push(String::new());
        Row::from(row)
    });
    let head = [
        "photograph",
        "distance (mm)",
        "incidence",
        "azimuth",
        "edge across",
        "exposure",
        "exposure used",
    ];
    table("Photographs", &head, &rows.collect::<Vec<_>>())
        + "<p>Turn each edge by some 5 degrees. Exposures count relative to that of the source; write \
           those that you used into the manifest.</p>\n"
}

/// Returns place and direction of a photograph as cells.
fn setup(own: &Photograph) -> [String; 4] {
    [
        own.floating_distance_mm.to_string(),
        format!("{}\u{b0}", own.incidence_deg),
        format!("{}\u{b0}", own.azimuth_deg),
        own.edge.name().to_owned(),
    ]
}

/// Writes the errors to expect.
fn errors(planned: &Planned) -> String {
    let rows = planned
        .expected
        .iter()
        .zip(&planned.even)
        .map(|(own, even)| {
            Row::from(vec![
                own.parameter.to_string(),
                percent(own.middle),
                percent(own.largest),
                percent(even.middle),
                percent(even.largest),
            ])
        });
    let head = [
        "parameter",
        "middle of the beliefs",
        "largest",
        "spread evenly: middle",
        "largest",
    ];
    let rows: Vec<Row> = rows.collect();
    format!(
        "<h2>Standard errors to expect</h2>\n{}",
        table("Standard errors", &head, &rows)
    )
}

/// Writes how well the photographs tell kernels apart, if the plan asks.
fn kernels(planned: &Planned) -> String {
    if planned.apart.is_empty() {
        return String::new();
    }
    let row = |(own, even): (&Apart, &Apart)| {
        let chi2 = |told: Told| format!("{} ({})", chi_square(told.middle), chi_square(told.least));
        let chance = |told: Told| {
            let [middle, least] = [told.middle, told.least].map(|own| 100.0 * own);
            format!("{middle:.1} % ({least:.1} %)")
        };
        Row::from(vec![
            format!("{}, not {}", own.right.name(), own.wrong.name()),
            chi2(own.chi2),
            chance(own.chance),
            chi2(even.chi2),
            chance(even.chance),
        ])
    };
    let rows: Vec<Row> = planned
        .apart
        .iter()
        .zip(&planned.even_apart)
        .map(row)
        .collect();
    let head = [
        "if this kernel is right",
        "chi-square",
        "it is named",
        "spread evenly: chi-square",
        "it is named",
    ];
    format!(
        "<h2>Telling kernels apart</h2>\n{}<p>In the middle of the beliefs; the least over their range \
         in brackets.</p>\n",
        table("Kernels", &head, &rows)
    )
}

/// Writes what each further photograph would bring.
fn further(planned: &Planned) -> String {
    if planned.further.is_empty() {
        return String::new();
    }
    let rows = planned.further.iter().map(|own| {
        let mut cells = vec!["<label><input type=\"checkbox\"/> further</label>".to_owned()];
        cells.extend(setup(&own.photograph));
        let errors: Vec<String> = Expected::by_kind(&own.expected)
            .into_iter()
            .map(|(kind, error)| format!("{} {}", kind.name(), percent(error)))
            .collect();
        cells.push(errors.join(", "));
        cells.extend(own.chi2.map(chi_square));
        Row::from(cells)
    });
    let rows: Vec<Row> = rows.collect();
    let mut head = vec![
        "photograph",
        "distance (mm)",
        "incidence",
        "azimuth",
        "edge across",
        "errors with it and those before",
    ];
    if !planned.apart.is_empty() {
        head.push("chi-square");
    }
    format!(
        "<h2>Further photographs</h2>\n{}",
        table("Further photographs", &head, &rows)
    )
}

/// Returns a relative error in percent.
fn percent(share: Option<f64>) -> String {
    share.map_or_else(
        || "unknown".into(),
        |share| format!("{:.3} %", 100.0 * share),
    )
}
