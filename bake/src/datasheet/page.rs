//! One or two data sheets on a page of HTML that needs neither network nor script.

use crate::datasheet::figures;
use crate::datasheet::map::EtaMap;
use crate::datasheet::report::{
    coarse, common, half, mtf50_ratio, number, ratio, sharpness, spread,
};
use crate::datasheet::sheet::Datasheet;
use charts::escape;
use std::fmt::Write;

const STYLE: &str = include_str!("page.css");

/// Writes the page of one cell, or of two that are compared.
pub(crate) fn page(sheets: &[Datasheet], command: &str) -> String {
    let names: Vec<String> = sheets.iter().map(|sheet| escape(&sheet.name)).collect();
    let title = names.join(" and ");
    let mut body = facts(sheets);
    match sheets {
        [a, b] => {
            body.push_str(&compared(a, b));
            body.push_str(&sharpness_of_both(a, b));
        }
        _ => sheets.iter().for_each(|sheet| body.push_str(&eta(sheet))),
    }
    body.push_str("<h2>Spots of dihedral errors</h2>\n<div class=\"pair\">\n");
    for sheet in sheets.iter().filter(|sheet| !sheet.spots.is_empty()) {
        if sheets.len() > 1 {
            let _ = writeln!(body, "<div><h3>{}</h3>", escape(&sheet.name));
        }
        let _ = writeln!(body, "<figure>{}</figure>", figures::spots(sheet));
        body.push_str(if sheets.len() > 1 { "</div>\n" } else { "" });
    }
    body.push_str("</div>\n");
    body.push_str(&tolerances(sheets));
    body.push_str(&notes(sheets, command));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"script-src 'none'; \
         connect-src 'none'; font-src 'none'; frame-src 'none'; object-src 'none'; img-src data:; \
         base-uri 'none'; form-action 'none'\"/>\n\
         <meta name=\"generator\" content=\"bake {}\"/>\n\
         <title>Data sheet: {title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<header>\n\
         <h1>{title}</h1>\n<p class=\"from\">Data sheet of a retroreflector cell, computed exactly \
         from its mesh</p>\n</header>\n<main>\n{body}</main>\n</body>\n</html>\n",
        env!("CARGO_PKG_VERSION"),
    )
}

/// Writes a table: its heads, then its rows, each with a head of its own.
fn table(heads: &[String], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let mut out = String::from("<div class=\"scroll\"><table>\n<thead><tr>");
    for head in heads {
        let _ = write!(out, "<th scope=\"col\">{}</th>", escape(head));
    }
    out.push_str("</tr></thead>\n<tbody>\n");
    for row in rows {
        out.push_str("<tr>");
        for (k, cell) in row.iter().enumerate() {
            let cell = escape(cell);
            let _ = match k {
                0 => write!(out, "<th scope=\"row\">{cell}</th>"),
                _ => write!(out, "<td>{cell}</td>"),
            };
        }
        out.push_str("</tr>\n");
    }
    out + "</tbody></table></div>\n"
}

/// Writes what the meshes say, one column for each cell.
fn facts(sheets: &[Datasheet]) -> String {
    let all: Vec<_> = sheets.iter().map(|sheet| sheet.cell.words()).collect();
    let mut heads = vec![String::new()];
    heads.extend(sheets.iter().map(|sheet| sheet.name.clone()));
    let row = |k: usize| {
        let words = all.iter().map(|words| words[k].1.clone());
        std::iter::once(all[0][k].0.to_owned())
            .chain(words)
            .collect()
    };
    table(&heads, (0..all[0].len()).map(row))
}

/// Writes maps and numbers of eta of one cell.
fn eta(sheet: &Datasheet) -> String {
    let mut heads = vec!["Mean over azimuths (least to largest)".to_owned()];
    let titles = sheet.surfaces.iter();
    heads.extend(titles.map(|own| own.surface.title(&sheet.request.metal)));
    let maps: Vec<&EtaMap> = sheet.surfaces.iter().map(|own| &own.map).collect();
    let row = |place: usize| {
        let of = |map: &&EtaMap| {
            let row = map.eta.row(place);
            let least = row.iter().copied().fold(f64::INFINITY, f64::min);
            let most = row.iter().copied().fold(0.0, f64::max);
            format!("{:.4} ({least:.4} to {most:.4})", map.means()[place])
        };
        let head = format!("{}\u{b0}", maps[0].incidence_deg[place]);
        std::iter::once(head).chain(maps.iter().map(of)).collect()
    };
    let mut rows: Vec<Vec<String>> = coarse(maps[0]).into_iter().map(row).collect();
    let halves = maps.iter().map(|map| half(map));
    rows.push(
        std::iter::once("half at".to_owned())
            .chain(halves)
            .collect(),
    );
    format!(
        "<h2>Retroreflected share eta</h2>\n<figure>{}</figure>\n{}",
        figures::maps(sheet),
        table(&heads, rows)
    )
}

/// Writes maps, differences and ratios of two cells.
fn compared(a: &Datasheet, b: &Datasheet) -> String {
    let names = [a.name.as_str(), b.name.as_str()];
    let mut out = String::new();
    for (surface, maps) in common(a, b) {
        let title = surface.title(&a.request.metal);
        let _ = writeln!(
            out,
            "<h2>Retroreflected share eta, {}</h2>\n<div class=\"pair\"><figure>{}</figure>\n\
             <figure>{}</figure></div>",
            escape(&title),
            figures::both(
                format!("Eta over incidence and azimuth, {title}"),
                names,
                maps
            ),
            figures::difference(names, maps)
        );
        let heads = [
            "Incidence".to_owned(),
            format!("{}, mean over azimuths", names[0]),
            format!("{}, mean over azimuths", names[1]),
            "difference".to_owned(),
            "ratio".to_owned(),
            "least to largest ratio".to_owned(),
        ];
        let means = maps.map(EtaMap::means);
        let row = |place: usize| {
            let [own, other] = [0, 1].map(|k| means[k][place]);
            let pairs = maps[0].eta.row(place);
            let ratios = pairs.iter().zip(maps[1].eta.row(place));
            let ratios: Vec<f64> = ratios.filter_map(|(a, b)| ratio(*a, *b)).collect();
            let range = match ratios.is_empty() {
                true => "-".to_owned(),
                false => format!(
                    "{:.4} to {:.4}",
                    ratios.iter().copied().fold(f64::INFINITY, f64::min),
                    ratios.iter().copied().fold(0.0, f64::max)
                ),
            };
            vec![
                format!("{}\u{b0}", maps[0].incidence_deg[place]),
                format!("{own:.4}"),
                format!("{other:.4}"),
                format!("{:+.4}", other - own),
                number(ratio(own, other)),
                range,
            ]
        };
        let mut rows: Vec<Vec<String>> = coarse(maps[0]).into_iter().map(row).collect();
        let halves = maps.map(half);
        rows.push(
            std::iter::once("half at".to_owned())
                .chain(halves)
                .collect(),
        );
        out.push_str(&table(&heads, rows));
    }
    out
}

/// Writes the MTF50 of two cells and their ratio.
fn sharpness_of_both(a: &Datasheet, b: &Datasheet) -> String {
    let of = |axis: &str| [&a.name, &b.name].map(|name| format!("{axis}, {name}"));
    let [first, second] = of("tangential");
    let [third, fourth] = of("sagittal");
    let ratio = "ratio".to_owned();
    let head = "Surface, incidence".to_owned();
    let heads = [head, first, second, ratio.clone(), third, fourth, ratio];
    let pairs = common(a, b).into_iter();
    let pairs = pairs.flat_map(|(surface, _)| sharpness(a, b, surface));
    let row = |pair: [&crate::datasheet::Tolerance; 2]| {
        let title = pair[0].surface.title(&a.request.metal);
        let mut row = vec![format!("{title}, {}\u{b0}", pair[0].incidence_deg)];
        for k in 0..2 {
            row.extend(pair.map(|own| number(own.mtf50_per_mm[k])));
            row.push(number(mtf50_ratio(pair, k)));
        }
        row
    };
    let conditions: String = [a, b]
        .iter()
        .map(|sheet| {
            let name = escape(&sheet.name);
            format!("<p>{name}: at {}.</p>\n", sheet.conditions())
        })
        .collect();
    format!(
        "<h2>MTF50 (1/mm)</h2>\n{conditions}{}",
        table(&heads, pairs.map(row))
    )
}

/// Writes eta and MTF50 with and without random errors.
fn tolerances(sheets: &[Datasheet]) -> String {
    let request = &sheets[0].request;
    let heads = [
        "Surface, incidence",
        "eta at the azimuth",
        "of random cells",
        "MTF50 (1/mm), tangential",
        "of random cells",
        "of a sheet of them",
        "MTF50 (1/mm), sagittal",
        "of random cells",
        "of a sheet of them",
    ];
    let mut out = format!(
        "<h2>Tolerance</h2>\n<p>{} random cells, seed {}: each dihedral angle has an independent \
         error with a standard deviation of {} mrad. Mean \u{b1} standard deviation of one cell \
         (least to largest).</p>\n",
        request.cells, request.seed, request.error_mrad,
    );
    for sheet in sheets {
        let row = |own: &crate::datasheet::Tolerance| {
            let title = own.surface.title(&request.metal);
            let mut row = vec![
                format!("{title}, {}\u{b0}", own.incidence_deg),
                format!("{:.4}", own.eta),
                spread(own.eta_spread),
            ];
            for k in 0..2 {
                row.extend([
                    number(own.mtf50_per_mm[k]),
                    spread(own.mtf50_spread[k]),
                    number(own.mtf50_of_sheet[k]),
                ]);
            }
            row
        };
        if sheets.len() > 1 {
            let _ = writeln!(out, "<h3>{}</h3>", escape(&sheet.name));
        }
        let _ = writeln!(out, "<p>At {}.</p>", sheet.conditions());
        out.push_str(&table(
            &heads.map(String::from),
            sheet.tolerances.iter().map(row),
        ));
    }
    out
}

/// Writes what the numbers mean, the remarks and the command.
fn notes(sheets: &[Datasheet], command: &str) -> String {
    let mut out = String::from(
        "<section class=\"notes\">\n<h2>Notes</h2>\n\
         <p>Eta is the share of the light on the entrance that returns as from a corner cube. Ideal \
         mirrors lose nothing, so their eta is the geometry alone. Metal and total reflection have \
         the losses of facets and of the front face, for unpolarised light. Half of eta is half of \
         its value at normal incidence on the same surface. MTF50 is the frequency in the mid-air \
         image at which the contrast is half: ray shift, diffraction and dihedral errors, without \
         the scatter of a real sheet. A sheet of random cells adds their light. Spots are those of \
         ideal mirrors.</p>\n",
    );
    let several = sheets.len() > 1;
    for sheet in sheets {
        let name = if several {
            format!("{}: ", sheet.name)
        } else {
            String::new()
        };
        for remark in &sheet.remarks {
            let _ = writeln!(out, "<p>{}</p>", escape(&format!("{name}{remark}")));
        }
        let hash = escape(&format!("{name}mesh {}", sheet.cell.mesh_hash));
        let _ = writeln!(out, "<p><code>{hash}</code></p>");
    }
    let _ = writeln!(out, "<p><code>{}</code></p>\n</section>", escape(command));
    out
}
