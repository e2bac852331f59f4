//! Error of an exact table between its directions, tried in the middles of its gaps.

use crate::run::bake::Bake;
use crate::run::trial;
use rayon::prelude::*;
use tables::Table;
use tables::cli::pool;

/// Largest number of directions that are tried, so that large tables take hardly longer.
const TRIED: usize = 64;

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
    /// Compares `table` with the exact method between its directions, or returns `None` if it is
    /// not exact, has a tolerance between its directions, or has no polygons that can be
    /// interpolated.
    ///
    /// The middles between neighbouring incidences and between neighbouring azimuths are tried. Of
    /// more than [`TRIED`], evenly spaced ones are taken.
    pub(crate) fn between(&self, table: &Table) -> Option<Between> {
        let bounded = table.provenance.direction_tolerance.is_some();
        let exact = self.exact.filter(|_| !bounded)?;
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
        all.retain(|&[incidence, azimuth]| {
            let found = table.direction(incidence, Some(azimuth));
            found.is_ok_and(|found| found.interpolated && found.paths.is_some())
        });
        let step = all.len().div_ceil(TRIED).max(1);
        let tried: Vec<[f64; 2]> = all.into_iter().step_by(step).collect();
        let errors = || {
            tried
                .par_iter()
                .map(|&[incidence_deg, azimuth_deg]| Between {
                    error: trial::error(exact, &self.rules, table, incidence_deg, azimuth_deg),
                    incidence_deg,
                    azimuth_deg,
                    tried: tried.len(),
                })
        };
        // Threads that cannot be started have ended the bake before.
        let pool = pool(self.plan.threads).ok()?;
        pool.install(|| errors().max_by(|a, b| a.error.total_cmp(&b.error)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::Prepared;
    use crate::plan::{Plan, Request};
    use crate::run::watch::Watch;
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
            let bake = Bake::new(&prepared, &plan).expect("a bake");
            let table = bake.table(Watch::none()).expect("a table");
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
