//! Numbers of data sheets: text for a person, CSV and JSON for a script.

use crate::datasheet::map::EtaMap;
use crate::datasheet::sheet::{CellFacts, Datasheet};
use crate::datasheet::spots::SpotDiagram;
use crate::datasheet::surface::Surface;
use crate::datasheet::tolerance::{Spread, Tolerance};
use meshes::EdgeLengthFrom;
use serde_json::{Value, json};
use std::fmt::Write;
use tables::cli::in_a_line;

/// Step of the incidences of short tables, degrees.
const COARSE_DEG: f64 = 10.0;

impl CellFacts {
    /// Returns the facts as names and sentences.
    pub(crate) fn words(&self) -> Vec<(&'static str, String)> {
        let unit = self.unit.as_deref().unwrap_or("file units, taken as mm");
        let from = match self.edge_length_from {
            EdgeLengthFrom::User => "--edge-length",
            EdgeLengthFrom::File => "stated by the mesh",
            EdgeLengthFrom::Longest => "longest edge from the apex",
        };
        let c = self.c_mm;
        // Further digits are rounding of the file.
        let digits = format!("{:.5e}", self.edge_length);
        let edge_length = digits.parse().unwrap_or(self.edge_length);
        let mut words = vec![
            ("Edge length c", format!("{edge_length} {unit} ({from})")),
            (
                "Depth",
                format!("{:.4} mm from the apex to the front", c * self.depth),
            ),
            (
                "Refractive index",
                match self.refractive_index {
                    1.0 => "1 (hollow)".into(),
                    index => index.to_string(),
                },
            ),
            (
                "Cubes",
                match self.cubes {
                    Some([1, _]) => "1 cube".into(),
                    Some([cubes, 1]) => format!("{cubes} equal cubes"),
                    Some([cubes, kinds]) => {
                        format!("{cubes} cubes of {kinds} kinds or orientations")
                    }
                    None => "one piece".into(),
                },
            ),
        ];
        words.push((
            "Lattice",
            match self.lattice {
                None => "none: cells stand alone, light that crosses the rim is lost".into(),
                Some([a, b]) => {
                    let [first, second] = [a, b].map(|[x, y]| x.hypot(y));
                    let cosine = (a[0] * b[0] + a[1] * b[1]) / (first * second);
                    format!(
                        "{:.4} mm and {:.4} mm, {:.2}\u{b0} apart",
                        c * first,
                        c * second,
                        cosine.clamp(-1.0, 1.0).acos().to_degrees()
                    )
                }
            },
        ));
        let turns = match self.symmetry.rotations {
            1 => "no rotation".into(),
            n => format!("{n} rotations"),
        };
        words.push((
            "Symmetry",
            match self.symmetry.mirror_deg {
                Some(deg) => format!("{turns}, a mirror plane at azimuth {deg:.2}\u{b0}"),
                None => turns,
            },
        ));
        words.push((
            "Digits",
            match self.coordinate_step {
                None => "all of a 64-bit number".into(),
                Some(step) => format!("coordinates in steps of {step:.0e} file units"),
            },
        ));
        words.push((
            "Dihedral errors",
            match self.dihedral_error_mrad {
                None => "no single corner of three planes in each cube".into(),
                Some(error) if error < 5e-5 => "none in the mesh (below 0.0001 mrad)".into(),
                Some(error) => format!("up to {error:.4} mrad in the mesh"),
            },
        ));
        words
    }
}

impl Datasheet {
    /// Describes the conditions of the tolerances, of eta and MTF50 in one direction.
    pub(crate) fn conditions(&self) -> String {
        let request = &self.request;
        // A length in another unit than mm has lost its short decimal form.
        let c_mm: f64 = format!("{:.5e}", self.cell.c_mm)
            .parse()
            .unwrap_or(self.cell.c_mm);
        format!(
            "azimuth {}\u{b0}, {} mm from the sheet, {} nm, corner size c {c_mm} mm, kernel wave \
             (ray shift, diffraction, dihedral errors); MTF50 tangential and sagittal",
            request.azimuth_deg, request.distance_mm, request.wavelength_nm,
        )
    }
}

/// Returns the incidences of short tables: their places on the axis of a map.
pub(crate) fn coarse(map: &EtaMap) -> Vec<usize> {
    let mut next = 0.0;
    let mut places = Vec::new();
    for (place, &deg) in map.incidence_deg.iter().enumerate() {
        if deg >= next - 1e-9 {
            places.push(place);
            next = deg + COARSE_DEG;
        }
    }
    places
}

/// Writes a number that may be none.
pub(crate) fn number(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{value:.4}"))
}

/// Writes the range of the angles of half eta.
pub(crate) fn half(map: &EtaMap) -> String {
    match map.half_range_deg() {
        [None, _] => format!("above {}\u{b0}", map.incidence_deg.last().unwrap_or(&0.0)),
        [Some(least), None] => format!(
            "{least:.2}\u{b0} to above {}\u{b0}",
            map.incidence_deg.last().unwrap_or(&0.0)
        ),
        [Some(least), Some(largest)] => format!("{least:.2}\u{b0} to {largest:.2}\u{b0}"),
    }
}

/// Writes a spread as mean, standard deviation and range.
pub(crate) fn spread(found: Option<Spread>) -> String {
    found.map_or("-".into(), |own| {
        format!(
            "{:.4} \u{b1} {:.4} ({:.4} to {:.4})",
            own.mean, own.standard_deviation, own.least, own.largest
        )
    })
}

/// Returns the ratio of two eta; `None` where the first is 0.
pub(crate) fn ratio(own: f64, other: f64) -> Option<f64> {
    (own > 0.0).then(|| other / own)
}

/// Returns the tolerances of a surface that both data sheets have, one pair for each incidence.
pub(crate) fn sharpness<'a>(
    a: &'a Datasheet,
    b: &'a Datasheet,
    surface: Surface,
) -> Vec<[&'a Tolerance; 2]> {
    let of = |sheet: &'a Datasheet| {
        let all = sheet.tolerances.iter();
        all.filter(move |own| own.surface == surface)
    };
    of(a).zip(of(b)).map(|(own, other)| [own, other]).collect()
}

/// Returns the ratio of two MTF50, tangential (0) or sagittal (1); `None` where one is not known.
pub(crate) fn mtf50_ratio([own, other]: [&Tolerance; 2], axis: usize) -> Option<f64> {
    let [own, other] = [own, other].map(|of| of.mtf50_per_mm[axis]);
    ratio(own?, other?)
}

/// Returns the maps of a surface that both data sheets have.
pub(crate) fn common<'a>(a: &'a Datasheet, b: &'a Datasheet) -> Vec<(Surface, [&'a EtaMap; 2])> {
    let own = a.surfaces.iter();
    let pairs = own.filter_map(|own| {
        let other = b
            .surfaces
            .iter()
            .find(|other| other.surface == own.surface)?;
        Some((own.surface, [&own.map, &other.map]))
    });
    pairs.collect()
}

/// Returns one or two data sheets as text.
pub(crate) fn text(sheets: &[Datasheet]) -> String {
    let mut out = String::new();
    for sheet in sheets {
        // Writing to a String cannot fail.
        let _ = writeln!(out, "{}", in_a_line(&sheet.name));
        for (name, words) in sheet.cell.words() {
            let _ = writeln!(out, "  {name:17} {}", in_a_line(&words));
        }
        let metal = &sheet.request.metal;
        for own in &sheet.surfaces {
            let title = own.surface.title(metal);
            let name = format!("{title}: eta {:.4} at 0\u{b0}", own.map.eta[[0, 0]]);
            let _ = writeln!(
                out,
                "  {name:34} half at {}, over all azimuths",
                half(&own.map)
            );
        }
        let _ = writeln!(out, "  At {}:", sheet.conditions());
        for own in &sheet.tolerances {
            let [tangential, sagittal] = own.mtf50_per_mm.map(number);
            let _ = writeln!(
                out,
                "  {}, {}\u{b0}: eta {:.4}, MTF50 {tangential} and {sagittal} /mm",
                own.surface.title(metal),
                own.incidence_deg,
                own.eta
            );
            if own.eta_spread.is_some() {
                let [tangential, sagittal] = own.mtf50_spread.map(spread);
                let _ = writeln!(
                    out,
                    "    {} cells: eta {}\n    MTF50 {tangential}\n      and {sagittal}",
                    sheet.request.cells,
                    spread(own.eta_spread)
                );
            }
        }
    }
    if let [a, b] = sheets {
        out.push_str(&both(a, b));
    }
    out
}

/// Returns the comparison of two data sheets as text.
fn both(a: &Datasheet, b: &Datasheet) -> String {
    let mut out = String::new();
    let names = [&a.name, &b.name].map(|name| in_a_line(name));
    for (surface, [own, other]) in common(a, b) {
        let title = surface.title(&a.request.metal);
        let _ = writeln!(
            out,
            "{title}: {} against {}\n  eta, mean over azimuths",
            names[1], names[0]
        );
        let (first, second) = (own.means(), other.means());
        for place in coarse(own) {
            let _ = writeln!(
                out,
                "  {:>4}\u{b0}  {:.4} and {:.4}, ratio {}",
                own.incidence_deg[place],
                first[place],
                second[place],
                number(ratio(first[place], second[place]))
            );
        }
        let _ = writeln!(
            out,
            "  MTF50 (1/mm) at azimuth {}\u{b0}, {} mm: tangential; sagittal",
            a.request.azimuth_deg, a.request.distance_mm
        );
        for pair in sharpness(a, b, surface) {
            let axis = |k: usize| {
                let [own, other] = pair.map(|of| number(of.mtf50_per_mm[k]));
                format!("{own} and {other}, ratio {}", number(mtf50_ratio(pair, k)))
            };
            let deg = pair[0].incidence_deg;
            let _ = writeln!(out, "  {deg:>4}\u{b0}  {}; {}", axis(0), axis(1));
        }
    }
    out
}

/// Returns the maps as CSV: one line for each surface and direction. Of two cells, the second's eta,
/// its difference from the first's and the ratio to it follow.
pub(crate) fn csv(sheets: &[Datasheet]) -> String {
    let two = sheets.len() == 2;
    let mut out = String::from("surface,incidence_deg,azimuth_deg,eta");
    out.push_str(if two {
        ",eta_of_second,difference,ratio\n"
    } else {
        "\n"
    });
    let pairs = match sheets {
        [a, b] => common(a, b),
        _ => {
            let own = sheets.iter().flat_map(|sheet| &sheet.surfaces);
            own.map(|own| (own.surface, [&own.map; 2])).collect()
        }
    };
    for (surface, [own, other]) in pairs {
        for ((i, a), &eta) in own.eta.indexed_iter() {
            let (incidence, azimuth) = (own.incidence_deg[i], own.azimuth_deg[a]);
            let _ = write!(out, "{},{incidence},{azimuth},{eta}", surface.name());
            if two {
                let second = other.eta[[i, a]];
                let ratio = ratio(eta, second).map_or(String::new(), |ratio| ratio.to_string());
                let _ = write!(out, ",{second},{},{ratio}", second - eta);
            }
            out.push('\n');
        }
    }
    out
}

/// Returns one or two data sheets as JSON.
pub(crate) fn json(sheets: &[Datasheet]) -> Value {
    let mut all = json!({ "cells": sheets.iter().map(of_sheet).collect::<Vec<Value>>() });
    if let [a, b] = sheets {
        let pair = |(surface, [own, other]): (Surface, [&EtaMap; 2])| {
            let pairs = || own.eta.iter().zip(&other.eta);
            let ratios: Vec<_> = pairs().map(|(a, b)| ratio(*a, *b)).collect();
            let differences: Vec<f64> = pairs().map(|(a, b)| b - a).collect();
            let width = own.azimuth_deg.len();
            let mtf50 = sharpness(a, b, surface).into_iter().map(|pair| {
                json!({
                    "incidence_deg": pair[0].incidence_deg,
                    "tangential": mtf50_ratio(pair, 0), "sagittal": mtf50_ratio(pair, 1),
                })
            });
            json!({
                "surface": surface.name(),
                "difference": differences.chunks(width).collect::<Vec<_>>(),
                "ratio": ratios.chunks(width).collect::<Vec<_>>(),
                "mtf50_ratio": mtf50.collect::<Vec<_>>(),
            })
        };
        all["second_against_first"] = common(a, b).into_iter().map(pair).collect();
    }
    all
}

fn of_sheet(sheet: &Datasheet) -> Value {
    let (cell, request) = (&sheet.cell, &sheet.request);
    let words: serde_json::Map<String, Value> = cell
        .words()
        .into_iter()
        .map(|(name, words)| (name.into(), json!(words)))
        .collect();
    let surface = |own: &crate::datasheet::SurfaceSheet| {
        let rows = own.map.eta.rows().into_iter().map(|row| row.to_vec());
        json!({
            "surface": own.surface.name(),
            "half_eta_deg": own.map.half_deg,
            "half_eta_range_deg": own.map.half_range_deg(),
            "eta": rows.collect::<Vec<_>>(),
        })
    };
    let spots = |own: &SpotDiagram| {
        let spot = |spot: &crate::datasheet::Spot| {
            json!({
                "across_mrad": spot.across_mrad, "along_mrad": spot.along_mrad, "share": spot.share,
            })
        };
        json!({
            "error_mrad": own.error_mrad, "incidence_deg": own.incidence_deg,
            "spots": own.spots.iter().map(spot).collect::<Vec<_>>(),
        })
    };
    let map = &sheet.surfaces[0].map;
    json!({
        "name": sheet.name, "design": cell.design, "mesh_hash": cell.mesh_hash, "edge_length": cell.edge_length,
        "unit": cell.unit, "c_mm": cell.c_mm, "refractive_index": cell.refractive_index,
        "coordinate_step": cell.coordinate_step, "depth": cell.depth, "lattice": cell.lattice,
        "symmetry_rotations": cell.symmetry.rotations,
        "symmetry_mirror_deg": cell.symmetry.mirror_deg, "cubes": cell.cubes,
        "entrance_area": cell.entrance_area, "dihedral_error_mrad": cell.dihedral_error_mrad,
        "words": words,
        "metal": request.metal, "metal_index": [request.metal_index.re, request.metal_index.im],
        "wavelength_nm": request.wavelength_nm, "distance_mm": request.distance_mm, "kernel": "wave",
        "azimuth_of_tolerances_deg": request.azimuth_deg,
        "error_mrad": request.error_mrad, "random_cells": request.cells, "seed": request.seed,
        "incidence_deg": map.incidence_deg, "azimuth_deg": map.azimuth_deg,
        "surfaces": sheet.surfaces.iter().map(surface).collect::<Vec<_>>(),
        "spots": sheet.spots.iter().map(spots).collect::<Vec<_>>(),
        "tolerances": sheet.tolerances.iter().map(of_tolerance).collect::<Vec<_>>(),
        "remarks": sheet.remarks,
    })
}

fn of_tolerance(own: &Tolerance) -> Value {
    let spread = |found: Option<Spread>| {
        found.map(|own| {
            json!({
                "least": own.least, "mean": own.mean, "largest": own.largest,
                "standard_deviation": own.standard_deviation,
            })
        })
    };
    let axes = |values: [Value; 2]| {
        let [tangential, sagittal] = values;
        json!({ "tangential": tangential, "sagittal": sagittal })
    };
    json!({
        "surface": own.surface.name(), "incidence_deg": own.incidence_deg, "eta": own.eta,
        "mtf50_per_mm": axes(own.mtf50_per_mm.map(|value| json!(value))),
        "eta_spread": spread(own.eta_spread),
        "mtf50_spread_per_mm": axes(own.mtf50_spread.map(|found| json!(spread(found)))),
        "mtf50_of_sheet_per_mm": axes(own.mtf50_of_sheet.map(|value| json!(value))),
    })
}
