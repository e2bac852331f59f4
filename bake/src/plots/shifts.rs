//! Pictures of the ray shifts of a table: polygons if it is exact, bins otherwise.

use crate::error::Error;
use crate::geometry::polygon::area;
use crate::plots::arrangement::{Piece, arrangement};
use crate::plots::choice::Choice;
use crate::plots::content::{Bins, Content};
use crate::plots::figure::{Figure, Panel, draw};
use glam::DVec2;
use std::path::Path;
use tables::{Exact, Table};

/// Largest number of pieces of a panel: 24 panels of this many have 6 MB as SVG.
const MOST_PIECES: usize = 4_000;

/// Smallest area of a piece, square edge lengths: a hundredth of a pixel wide.
const LEAST_AREA: f64 = 1e-9;

/// Part of the square of its stretch by which a map must enlarge areas.
///
/// Where it does not, all light of a polygon falls on a line, where its density has no bound.
const FLAT: f64 = 1e-3;

/// Returns a picture of the ray shifts of `table` as the bytes of a PNG or SVG file.
///
/// The picture has one panel per direction, with the retroreflected fraction above it: u to the
/// right, v upward. The colour is the density per launched ray and square edge length. The
/// extension of `file` names the format.
///
/// # Errors
/// Returns the errors of [`draw`].
pub(crate) fn shifts(table: &Table, file: &Path) -> Result<Vec<u8>, Error> {
    let choice = Choice::of(table);
    let contents = choice.directions.iter().map(|&at| content(table, at));
    let contents: Vec<Content> = contents.collect();
    let is_exact = |content: &&Content| matches!(content, Content::Polygons(..));
    let exact = contents.iter().filter(is_exact).count();
    let width = table.axes.bin_width();
    let drawn = match exact {
        0 => format!("bins of {width} edge lengths"),
        _ if exact == contents.len() => "exact polygons".into(),
        _ => format!("exact polygons; bins of {width} edge lengths where said"),
    };
    let mixed = exact > 0;
    let panels = choice.directions.iter().zip(contents);
    let panels = panels.map(|(&at, content)| {
        let binned = mixed && matches!(content, Content::Bins(_));
        Panel::new(table, at, content, binned.then_some("bins"))
    });
    let figure = Figure {
        title: format!("{}: ray shift p' - p, {drawn}", table.provenance.design),
        note: choice.note,
        axes: ["u, edge lengths", "v, edge lengths"],
        bar: "share of launched light per square edge length",
        panels: panels.collect(),
        columns: choice.columns,
    };
    draw(&figure, file)
}

/// Returns the distribution of the shifts of a direction.
fn content(table: &Table, (i, a): (usize, usize)) -> Content {
    let (_, azimuths) = table.axes.shape();
    let exact = table.exact.as_ref();
    let exact = exact.and_then(|exact| polygons(exact, i * azimuths + a));
    exact.unwrap_or_else(|| bins(table, (i, a)))
}

/// Returns the polygons of the shifts of a direction.
///
/// Returns `None` if light falls on a line, and if the polygons have too many pieces.
fn polygons(exact: &Exact, direction: usize) -> Option<Content> {
    let mut sheets = Vec::new();
    for path in exact.paths.get(direction)? {
        let [[a, b], [c, d]] = path.matrix;
        let stretch = a * a + b * b + c * c + d * d;
        let enlarged = a * d - b * c;
        let density = path.weight / (exact.entrance_area * enlarged.abs());
        if path.weight == 0.0 || path.polygon.len() < 3 {
            continue;
        }
        if enlarged.abs() <= FLAT * stretch {
            return None;
        }
        let mut polygon: Vec<DVec2> = path
            .polygon
            .iter()
            .map(|&entry| DVec2::from(path.shift(entry)))
            .collect();
        if enlarged < 0.0 {
            polygon.reverse();
        }
        sheets.push(Piece { polygon, density });
    }
    // Small polygons cut the large ones up less if they come last.
    sheets.sort_by(|p, q| area(&q.polygon).total_cmp(&area(&p.polygon)));
    let pieces = arrangement(&sheets, LEAST_AREA, MOST_PIECES)?;
    let outlines = sheets.into_iter().map(|sheet| sheet.polygon).collect();
    Some(Content::Polygons(pieces, outlines))
}

/// Returns the bins of the shifts of a direction.
fn bins(table: &Table, (i, a): (usize, usize)) -> Content {
    let width = table.axes.bin_width();
    let probability = table.probability(i, a);
    let density = probability.outer_iter().map(|row| {
        let row = row.iter().map(|p| p / (width * width));
        row.collect::<Vec<f64>>()
    });
    Content::Bins(Bins {
        density: density.collect(),
        corner: DVec2::splat(-table.axes.range),
        width,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use tables::Path as Light;

    fn path(polygon: &[[f64; 2]], matrix: [[f64; 2]; 2], weight: f64) -> Light {
        Light {
            polygon: polygon.to_vec(),
            matrix,
            offset: [0.25, 0.0],
            weight,
            deviation: [0.0; 2],
            passes: 0,
            jones: None,
        }
    }

    /// Checks that the densities of a direction hold all of its light, that a map that mirrors is
    /// drawn too, and that light on a line is not drawn as a polygon.
    #[test]
    fn polygons_hold_the_light_of_their_paths() {
        let square = [[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]];
        let turned = path(&square, [[-2.0, 0.0], [0.0, -2.0]], 1.0);
        let mirrored = path(&square, [[-2.0, 0.0], [0.0, 2.0]], 0.5);
        let flat = path(&square, [[0.0, 0.0], [0.0, -2.0]], 1.0);
        let exact = |paths: Vec<Light>| Exact {
            entrance_area: 2.0,
            paths: vec![paths],
        };
        let light = |content: &Content| -> f64 {
            let Content::Polygons(pieces, _) = content else {
                panic!("{content:?}");
            };
            pieces.iter().map(|p| p.density * area(&p.polygon)).sum()
        };
        let both = polygons(&exact(vec![turned.clone(), mirrored, turned.clone()]), 0);
        let both = both.expect("no map is flat");
        // 0.25 of 2 square edge lengths enter by each path, of which 1, 1 and 0.5 return. All
        // numbers are sums of powers of 2, so nothing is rounded.
        assert_eq!(light(&both), 2.5 * 0.25 / 2.0);
        // The equal squares have 1 / (2 x 4) each.
        let densest = both.light().into_iter().map(|[density, _]| density);
        assert_eq!(densest.fold(0.0, f64::max), 0.25);
        let expected = (DVec2::new(-0.75, -1.0), DVec2::new(0.25, 1.0));
        assert_eq!(both.extent(), expected);
        assert!(polygons(&exact(vec![turned, flat]), 0).is_none());
        let nothing = polygons(&exact(Vec::new()), 0).expect("no map is flat");
        assert_eq!(light(&nothing), 0.0);
    }
}
