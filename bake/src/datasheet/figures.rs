//! Pictures of a data sheet as SVG: polar maps of eta and of differences, and spots.

use crate::datasheet::map::EtaMap;
use crate::datasheet::sheet::Datasheet;
use crate::datasheet::spots::{ERRORS_MRAD, SpotDiagram};
use charts::{Axis, Bar, Curve, Facet, Figure, Ground, HUES, Image, Marks, STEPS, Stroke};

/// Cells along a side of a map.
const CELLS: usize = 220;

/// Width and height of a polar panel, pixels.
const FRAME: [f64; 2] = [250.0, 250.0];

/// Room around the map within its panel.
const ROOM: f64 = 1.2;

/// Draws the maps of all surfaces of a cell beside each other, on one scale.
pub(crate) fn maps(sheet: &Datasheet) -> String {
    let all = sheet.surfaces.iter();
    let highest = highest(all.clone().map(|own| &own.map));
    let facets = all.map(|own| {
        let title = own.surface.title(&sheet.request.metal);
        polar(title, &own.map, highest, false)
    });
    figure(
        "Eta over incidence (radius) and azimuth (angle)",
        facets.collect(),
        sheet.surfaces.len(),
        (highest, false),
    )
}

/// Draws the maps of two cells on one surface, beside each other, on one scale.
pub(crate) fn both(title: String, names: [&str; 2], maps: [&EtaMap; 2]) -> String {
    let highest = highest(maps.into_iter());
    let facets = [0, 1].map(|k| polar(names[k].to_owned(), maps[k], highest, false));
    figure(&title, facets.into(), 2, (highest, false))
}

/// Draws the difference of the maps of two cells: the second less the first.
pub(crate) fn difference(names: [&str; 2], maps: [&EtaMap; 2]) -> String {
    let map = maps[0].with(&maps[1].eta - &maps[0].eta);
    let largest = map
        .eta
        .iter()
        .fold(0.0_f64, |most, value| most.max(value.abs()));
    let head = format!("{} less {}", names[1], names[0]);
    let facets = vec![polar(head, &map, largest, true)];
    figure("Difference of eta", facets, 1, (largest, true))
}

fn highest<'a>(maps: impl Iterator<Item = &'a EtaMap>) -> f64 {
    maps.flat_map(|map| map.eta.iter().copied())
        .fold(0.0, f64::max)
}

fn figure(title: &str, facets: Vec<Facet>, columns: usize, scale: (f64, bool)) -> String {
    let (highest, is_signed) = scale;
    let has_line = facets.iter().any(|facet| !facet.curves.is_empty());
    let figure = Figure {
        note: match (has_line, is_signed) {
            (true, _) => "line: half of eta at normal incidence; white: no light returns".into(),
            (false, false) => "white: no light returns".into(),
            (false, true) => String::new(),
        },
        frame: FRAME,
        bar: Some(Bar {
            highest,
            is_signed,
            name: match is_signed {
                true => "difference of eta".into(),
                false => "eta, share of the light that returns".into(),
            },
        }),
        ..Figure::new(title, facets, columns)
    };
    figure.svg()
}

/// Makes the panel of a map, with the line of half eta over it.
fn polar(head: String, map: &EtaMap, highest: f64, is_signed: bool) -> Facet {
    let radius = map.incidence_deg.last().copied().unwrap_or(1.0);
    let step = |x: f64, y: f64| {
        let incidence = x.hypot(y);
        if incidence > radius {
            return 0;
        }
        let eta = map.at(incidence, y.atan2(x).to_degrees());
        let part = match (highest > 0.0, is_signed) {
            (false, _) => 0.0,
            (_, true) => 0.5 + 0.5 * eta / highest,
            (_, false) => eta / highest,
        };
        let last = f64::from(STEPS - 1);
        match is_signed || eta > 0.0 {
            true => 1 + (part * last).round().clamp(0.0, last) as u8,
            false => 0,
        }
    };
    let place = |k: usize| radius * (2.0 * (k as f64 + 0.5) / CELLS as f64 - 1.0);
    let row = |k: usize| (0..CELLS).map(|l| step(place(l), -place(k))).collect();
    let steps: Vec<Vec<u8>> = (0..CELLS).map(row).collect();
    let (from, to) = ([-radius; 2], [radius; 2]);
    let image = match is_signed {
        true => Image::of_differences(&steps, from, to),
        false => Image::of(&steps, from, to),
    };
    let axis = Axis::linear(-ROOM * radius, ROOM * radius);
    Facet {
        ground: Ground::Polar(image, radius),
        ..Facet::new(head, [axis; 2], ["incidence (\u{b0})", ""], half(map))
    }
}

/// Returns the line of half eta, open where eta stays above half.
fn half(map: &EtaMap) -> Vec<Curve> {
    if map.half_deg.iter().all(Option::is_none) {
        return Vec::new();
    }
    let around = (0..map.azimuth_deg.len()).chain([0]);
    let point = |k: usize| {
        let (sine, cosine) = map.azimuth_deg[k].to_radians().sin_cos();
        let radius = map.half_deg[k].unwrap_or(f64::NAN);
        [radius * cosine, radius * sine]
    };
    vec![Curve::new(
        "",
        Stroke::solid(HUES[1]),
        Marks::Line,
        around.map(point),
    )]
}

/// Draws the spots of each incidence, one colour for each error.
pub(crate) fn spots(sheet: &Datasheet) -> String {
    let largest = sheet.spots.iter().map(SpotDiagram::largest_mrad);
    let largest = 1.15 * largest.fold(0.0, f64::max).max(1e-6);
    let axes = [Axis::linear(-largest, largest); 2];
    let facet = |&incidence: &f64| {
        let own = sheet
            .spots
            .iter()
            .filter(|own| own.incidence_deg == incidence);
        let curve = |own: &SpotDiagram| {
            let which = ERRORS_MRAD
                .iter()
                .position(|error| *error == own.error_mrad);
            let points = own
                .spots
                .iter()
                .map(|spot| [spot.across_mrad, spot.along_mrad]);
            Curve::new(
                format!("{} mrad", own.error_mrad),
                Stroke::solid(HUES[which.unwrap_or(0)]),
                Marks::Dots,
                points,
            )
        };
        let names = [
            "in the plane of incidence (mrad)",
            "across the plane of incidence (mrad)",
        ];
        let head = format!("incidence {incidence}\u{b0}");
        Facet::new(head, axes, names, own.map(curve).collect())
    };
    let facets: Vec<Facet> = sheet.request.incidence_deg.iter().map(facet).collect();
    let columns = facets.len();
    let figure = Figure {
        note: "by the error of all three dihedral angles".into(),
        frame: [230.0, 230.0],
        ..Figure::new("Directions in which light leaves", facets, columns)
    };
    figure.svg()
}
