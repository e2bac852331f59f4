//! Error of an interpolated table in one direction, against the exact method.

use glam::DVec2;
use tables::{Fate, Path, Table};

use crate::beams::exact;
use crate::cell::ExactCell;
use crate::geometry::polygon;
use crate::optics::Rules;
use crate::plan::default;

/// Error of a direction whose polygons cannot be interpolated. No other error is as great.
pub(crate) const OPEN: f64 = 1.0;

/// Largest error of an exit direction, rad: 5 um at a distance of 1 m, a twentieth of the smallest
/// corners.
///
/// Light that leaves in a direction farther off counts as light in a wrong bin.
const ASTRAY_RAD: f64 = 5e-6;

/// Returns the total variation between the interpolated table and the truth in one direction,
/// degrees, or the share of the light astray if that is more.
pub(crate) fn error(
    exact: &ExactCell,
    rules: &Rules,
    table: &Table,
    incidence_deg: f64,
    azimuth_deg: f64,
) -> f64 {
    let paths = table
        .direction(incidence_deg, Some(azimuth_deg))
        .ok()
        .and_then(|found| found.paths);
    let Some(paths) = paths else { return OPEN };
    // The bins are always the default ones, so that a tolerance has one meaning.
    let (bins, range) = (default::BINS, default::RANGE);
    let truth = exact.direction(incidence_deg, azimuth_deg, bins, range, rules);
    let (mass, outside) = exact::spread(&paths, exact.entrance_area(), bins, range);
    let bins = mass
        .iter()
        .zip(&truth.histogram)
        .map(|(a, b)| (a - b).abs());
    let shifted =
        0.5 * (bins.sum::<f64>() + (outside - truth.fate[Fate::OutOfRange as usize]).abs());
    let astray: f64 = paths
        .iter()
        .filter(|path| is_astray(path, &truth.paths))
        .map(|path| {
            let corners = path.polygon.iter().map(|&corner| DVec2::from(corner));
            path.weight * polygon::area(&corners.collect::<Vec<_>>())
        })
        .sum();
    shifted.max(astray / exact.entrance_area())
}

/// Returns whether no path of the truth leaves in the direction of `path`.
fn is_astray(path: &Path, truth: &[Path]) -> bool {
    let apart = |own: &Path| {
        let [x, y] = [0, 1].map(|k| own.deviation[k] - path.deviation[k]);
        x.hypot(y)
    };
    path.deviation != [0.0; 2] && truth.iter().all(|own| apart(own) > ASTRAY_RAD)
}
