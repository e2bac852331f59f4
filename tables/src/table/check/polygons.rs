//! The check of the polygons of an exact table.

use crate::table::check::{FARTHEST, Invalid, SUM, broken, most, shape, within};
use crate::table::exact::{Cube, Exact, Path};
use crate::table::flat::FlatPaths;
use crate::table::table::Table;

/// Greatest number of paths of a direction.
///
/// Cubes with worn edges, errors and a front that traps light have 32. A curved face that planes
/// stand for has 14,000 with 1,536 facets, and 19,000 with 2,048, the most that the exact method
/// takes.
const MOST_PATHS: usize = 1 << 15;

/// Greatest product of two normals of a cube; `bake` takes planes for a cube's up to half of it.
const MOST_SKEW: f64 = 0.2;

/// Greatest number of corners of a polygon. Those of all designs have up to 9.
const MOST_CORNERS: usize = 64;

/// Greatest number of polygons of a direction whose shifts cover the whole histogram, together.
///
/// Whoever sums them up over the bins spends a pass over all bins for each. The tens of polygons of
/// a sheet cover some per cent each, the thousands of a curved face far less.
const MOST_COVERS: usize = 1024;

/// Returns the part of a histogram in which the shifts of a path lie, by the rectangle around them.
fn cover(path: &Path, range: f64) -> f64 {
    let shifts: Vec<[f64; 2]> = path
        .polygon
        .iter()
        .map(|&corner| path.shift(corner))
        .collect();
    let side = |axis: usize| {
        let along = shifts.iter().map(|shift| shift[axis].clamp(-range, range));
        let (low, high) = along.fold((range, -range), |(low, high), x| (low.min(x), high.max(x)));
        (high - low).max(0.0) / (2.0 * range)
    };
    side(0) * side(1)
}

/// Returns whether planes are a cube's: their normals are unit vectors at right angles within
/// [`MOST_SKEW`].
fn is_cube(cube: &Cube) -> bool {
    let dot = |a: usize, b: usize| -> f64 { (0..3).map(|k| cube[a][k] * cube[b][k]).sum() };
    let pairs = (0..3).flat_map(|a| (0..=a).map(move |b| (a, b)));
    let off = |(a, b)| dot(a, b) - f64::from(u8::from(a == b));
    pairs.map(off).all(|off| off.abs() <= MOST_SKEW)
}

/// Checks the polygons of an exact table: numbers, corners, areas, and their sum against eta.
pub(super) fn polygons(table: &Table, exact: &Exact) -> Result<(), Invalid> {
    let (incidences, azimuths) = table.axes.shape();
    // A mean over azimuths has no polygons of its own. Its lists are empty, or hold polygons that
    // belong to no single direction.
    let directions = [incidences * azimuths];
    shape("exact paths", &[exact.paths.len()], &directions)?;
    within(
        "entrance_area",
        [&exact.entrance_area],
        "above 0 to 1e12",
        |x| x > 0.0 && x <= FARTHEST * FARTHEST,
    )?;
    for (direction, paths) in exact.paths.iter().enumerate() {
        let number = || format!("the paths of direction {direction}");
        most(MOST_PATHS, paths.len(), number)?;
        for (index, path) in paths.iter().enumerate() {
            let corners = || format!("the corners of path {index} of direction {direction}");
            most(MOST_CORNERS, path.polygon.len(), corners)?;
        }
        let covers: f64 = paths.iter().map(|path| cover(path, table.axes.range)).sum();
        let all_over = || format!("the polygons over the whole histogram of direction {direction}");
        most(MOST_COVERS, covers as usize, all_over)?;
    }
    let flat = FlatPaths::new(exact);
    // Sums of products of such numbers are finite, and no light goes farther than [`FARTHEST`].
    let bounded = |x: f64| x.abs() <= FARTHEST;
    within("path_matrix", &flat.matrix, "-1e6 to 1e6", bounded)?;
    within("path_offset", &flat.offset, "-1e6 to 1e6", bounded)?;
    within("path_deviation", &flat.deviation, "-1e6 to 1e6", bounded)?;
    within("path_jones", &flat.jones, "-1e6 to 1e6", bounded)?;
    within("path_cube", &flat.cube, "-2 to 2", |x| x.abs() <= 2.0)?;
    within("path_weight", &flat.weight, "0 to 1", |x| {
        (0.0..=1.0).contains(&x)
    })?;
    within("polygon_vertex", &flat.vertex, "-1e6 to 1e6", bounded)?;
    for (direction, paths) in exact.paths.iter().enumerate() {
        let mut returned = 0.0;
        for (index, path) in paths.iter().enumerate() {
            if path.cube.is_some_and(|cube| !is_cube(&cube)) {
                broken!("path_cube {index} of direction {direction} has planes that are no cube's");
            }
            let area = crate::table::polygon::area(&path.polygon);
            // Rounding may give a sliver an area just below 0.
            if path.polygon.len() < 3 || area < -SUM * exact.entrance_area {
                let corners = path.polygon.len();
                broken!(
                    "path {index} of direction {direction} has a polygon of {corners} corners and \
                    area {area}"
                );
            }
            returned += path.weight * area / exact.entrance_area;
        }
        let here = (direction / azimuths, direction % azimuths);
        let eta = table.retroreflected[[here.0, here.1]];
        if !table.axes.is_mean() && (returned - eta).abs() > SUM {
            broken!(
                "polygons of direction {here:?} return {returned} of the power, retroreflected \
                says {eta}"
            );
        }
    }
    Ok(())
}
