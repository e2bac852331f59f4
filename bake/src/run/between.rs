//! Error of an exact table between its directions, against the exact method, as far as it was tried.

use crate::beams::exact;
use crate::cell::ExactCell;
use crate::geometry::polygon;
use crate::optics::Rules;
use crate::plan::default;
use crate::run::bake::Bake;
use glam::DVec2;
use rayon::prelude::*;
use tables::cli::pool;
use tables::{Fate, Path, Table};

/// Largest number of directions that are tried after a bake.
const MOST_TRIED: usize = 64;

/// Number of paths of a direction up to which so many directions are tried.
///
/// The paths of neighbouring directions are compared with each other, so that the time of a trial
/// grows with the square of their number. With more paths fewer directions are tried, and none
/// beyond 512 paths: the trials would take far longer than the bake.
const FEW_PATHS: usize = 64;

/// Largest error of an interpolated table among directions that were tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Between {
    /// Total variation of eta x histogram, or the share of the light astray if that is more.
    pub error: f64,
    /// Incidence of the direction, degrees.
    pub incidence_deg: f64,
    /// Azimuth of the direction, degrees.
    pub azimuth_deg: f64,
    /// Number of directions that were tried.
    pub tried: usize,
}

impl Bake<'_> {
    /// Returns the largest error of `table` between its directions, among those tried: by the
    /// choice of directions, or else now.
    ///
    /// The middles between neighbouring incidences and between neighbouring azimuths are tried
    /// now, evenly spaced ones of more than [`MOST_TRIED`]. Returns `None` if the table is not
    /// exact, or has no polygons or too many to be interpolated.
    pub(crate) fn between(&self, table: &Table) -> Option<Between> {
        let exact = self.exact?;
        if self.chosen.is_some() {
            return self.chosen;
        }
        let (incidences, azimuths) = (&table.axes.incidence_deg, &table.axes.azimuth_deg);
        let middles = |ends: &[f64]| -> Vec<f64> {
            let pairs = ends.windows(2);
            pairs.map(|pair| 0.5 * (pair[0] + pair[1])).collect()
        };
        let cross = |along: &[f64], across: &[f64]| -> Vec<[f64; 2]> {
            let all = along.iter();
            all.flat_map(|&i| across.iter().map(move |&a| [i, a]))
                .collect()
        };
        let mut all = cross(&middles(incidences), azimuths);
        all.extend(cross(incidences, &middles(azimuths)));
        let paths = table.exact.as_ref()?.paths.iter().map(Vec::len).max()?;
        let most = MOST_TRIED * FEW_PATHS.pow(2) / paths.max(FEW_PATHS).pow(2);
        let apart = all.len().div_ceil(most.max(1)).max(1);
        let tried: Vec<[f64; 2]> = all.into_iter().step_by(apart).take(most).collect();
        let error = |&[incidence_deg, azimuth_deg]: &[f64; 2]| {
            let found = table.direction(incidence_deg, Some(azimuth_deg));
            let known = found.is_ok_and(|found| found.interpolated && found.paths.is_some());
            known.then(|| Between {
                error: error_at(exact, &self.rules, table, incidence_deg, azimuth_deg),
                incidence_deg,
                azimuth_deg,
                tried: 1,
            })
        };
        // Threads that cannot be started have ended the bake before.
        let pool = pool(self.plan.threads).ok()?;
        let found: Vec<Between> = pool.install(|| tried.par_iter().filter_map(error).collect());
        let largest = found.iter().max_by(|a, b| a.error.total_cmp(&b.error))?;
        Some(Between {
            tried: found.len(),
            ..*largest
        })
    }
}

/// Error of a direction whose polygons cannot be interpolated. No other error is as great.
pub(crate) const OPEN: f64 = 1.0;

/// Largest error of an exit direction, rad: 5 um at a distance of 1 m, a twentieth of the smallest
/// corners.
///
/// Light that leaves in a direction farther off counts as light in a wrong bin.
const ASTRAY_RAD: f64 = 5e-6;

/// Returns the total variation between the interpolated table and the truth in one direction,
/// degrees, or the share of the light astray if that is more.
pub(crate) fn error_at(
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::Prepared;
    use crate::plan::{Plan, Request};
    use crate::run::bake::Progress;
    use meshes::design::{Design, Shape};
    use tables::options::Back;

    fn request(incidence: &str, back: Back) -> Request {
        Request {
            incidence: incidence.into(),
            azimuth: "30".into(),
            refractive_index: Some(1.49),
            back,
            ..Request::default()
        }
    }

    /// The stated error is half the sum of the differences between the bins of the interpolated
    /// table and those of a table of the middle itself. Bare facets of index 1.49 stop to reflect
    /// between 20 and 30 degrees at azimuth 30, which no interpolation follows.
    #[test]
    fn the_error_is_that_against_a_table_of_the_middles() {
        let mesh = Design::new(Shape::TriangularPair).mesh().expect("a mesh");
        let cell = meshes::normalise(&mesh, "cell.obj".as_ref(), &meshes::CellOptions::default());
        let prepared = Prepared::new(cell.expect("a cell"));
        let baked = |request: &Request| {
            let plan = Plan::new(request).expect("a valid request");
            let bake = Bake::new(&prepared, &plan, Progress::none()).expect("a bake");
            let table = bake.table(Progress::none()).expect("a table");
            let between = bake.between(&table);
            (table, between)
        };
        let mut found = Vec::new();
        for back in [Back::Mirror, Back::Tir] {
            let (coarse, between) = baked(&request("20,30", back));
            let between = between.expect("a middle");
            let at = (between.incidence_deg, between.azimuth_deg, between.tried);
            assert_eq!(at, (25.0, 30.0, 1));
            let (fine, none) = baked(&request("25", back));
            assert_eq!(none, None, "one direction has nothing between");
            let own = coarse.direction(25.0, Some(30.0)).expect("covered");
            let paths = own.paths.expect("polygons");
            let exact = prepared.exact().expect("planar");
            let (bins, range) = (fine.axes.bins, fine.axes.range);
            let area = exact.entrance_area();
            let (mass, _) = crate::beams::exact::spread(&paths, area, bins, range);
            let eta = fine.retroreflected[[0, 0]];
            let truth = fine.histogram.iter().map(|share| eta * share);
            let apart = mass.iter().zip(truth).map(|(a, b)| (a - b).abs());
            let variation = 0.5 * apart.sum::<f64>();
            println!("{:e} {variation:e}", between.error);
            // Some 10^4 bins round by 1e-16 each.
            assert!((between.error - variation).abs() < 1e-11);
            found.push(between.error);
        }
        assert!(found[0] < 0.01 && found[1] > 0.05, "{found:?}");
    }
}
