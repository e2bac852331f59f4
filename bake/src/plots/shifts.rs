//! Pictures of the ray shifts of a table: polygons if it is exact, bins otherwise.

use crate::plots::choice::Choice;
use crate::plots::heat::{Cells, Content, DirectionPanel, Picture, UniformPolygon};
use glam::DVec2;
use tables::{Exact, Table};

/// Part of the square of its stretch by which a map must enlarge areas.
///
/// Where it does not, all light of a polygon falls on a line, where its density has no bound.
const FLAT: f64 = 1e-3;

/// Returns a picture of the ray shifts of `table` as SVG.
///
/// The picture has one panel per direction, with the retroreflected fraction above it: u to the
/// right, v upward. The colour is the density per launched ray and square edge length.
pub(crate) fn shifts(table: &Table) -> String {
    let choice = Choice::of(table);
    let contents = choice.directions.iter().map(|&at| content(table, at));
    let contents: Vec<Content> = contents.collect();
    let is_exact = |content: &&Content| matches!(content, Content::Polygons(_));
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
        DirectionPanel::new(table, at, content, if binned { ", bins" } else { "" })
    });
    let picture = Picture {
        title: format!("{}: ray shift p' - p, {drawn}", table.provenance.design),
        note: choice.note.unwrap_or_default(),
        axes: ["u, edge lengths", "v, edge lengths"],
        bar: "share of launched light per square edge length",
        panels: panels.collect(),
        columns: choice.columns,
    };
    picture.svg()
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
/// Returns `None` if light falls on a line.
fn polygons(exact: &Exact, direction: usize) -> Option<Content> {
    let mut shown = Vec::new();
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
        let polygon: Vec<DVec2> = path
            .polygon
            .iter()
            .map(|&entry| DVec2::from(path.shift(entry)))
            .collect();
        shown.push(UniformPolygon { polygon, density });
    }
    Some(Content::Polygons(shown))
}

/// Returns the bins of the shifts of a direction.
fn bins(table: &Table, (i, a): (usize, usize)) -> Content {
    let width = table.axes.bin_width();
    let probability = table.probability(i, a);
    let density = probability.outer_iter().map(|row| {
        let row = row.iter().map(|p| p / (width * width));
        row.collect::<Vec<f64>>()
    });
    Content::Bins(Cells {
        density: density.collect(),
        corner: DVec2::splat(-table.axes.range),
        size: DVec2::splat(width),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::polygon::area;
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
            cube: None,
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
        let shown = |paths: Vec<Light>| match polygons(&exact(paths), 0) {
            Some(Content::Polygons(shown)) => shown,
            other => panic!("{other:?}"),
        };
        let both = shown(vec![turned.clone(), mirrored, turned.clone()]);
        // 0.25 of 2 square edge lengths enter by each path, of which 1, 0.5 and 1 return. All
        // numbers are sums of powers of 2, so nothing is rounded.
        let light = both.iter().map(|s| s.density * area(&s.polygon).abs());
        assert_eq!(light.sum::<f64>(), 2.5 * 0.25 / 2.0);
        assert_eq!(
            both.iter().map(|s| s.density).collect::<Vec<_>>(),
            [0.125, 0.0625, 0.125]
        );
        let corners = both.iter().flat_map(|s| &s.polygon);
        let (low, high) = corners.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| {
            (l.min(*p), h.max(*p))
        });
        assert_eq!(
            (low, high),
            (DVec2::new(-0.75, -1.0), DVec2::new(0.25, 1.0))
        );
        assert!(polygons(&exact(vec![turned, flat]), 0).is_none());
        assert!(shown(Vec::new()).is_empty());
    }
}
