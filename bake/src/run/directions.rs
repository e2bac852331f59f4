//! Choice of directions between which a table is interpolated to a given tolerance.
//!
//! The distance of two distributions is the total variation of eta x histogram, or the share of the
//! light that leaves in a wrong direction if that is more.
//!
//! The search begins with the ends of the angles asked for. It interpolates the table in the middle
//! between neighbouring incidences and between neighbouring azimuths. It compares the result with
//! the exact method. Where the two differ by more than the tolerance, it halves the gap. Then it
//! checks random directions too. So the directions lie close together where paths end or lose a
//! corner, and far apart elsewhere. Nothing is proved of directions that were not tried.

use crate::cell::ExactCell;
use crate::error::Error;
use crate::geometry::Stream;
use crate::plan::default;
use crate::run::bake::Bake;
use crate::run::bake::Progress;
use crate::run::between::{Between, OPEN, error_at};
use rayon::prelude::*;
use tables::cli::pool;
use tables::options::Sampler;
use tables::{Axes, Table};

/// Part of the tolerance that the search aims at, because it tries only some of all directions.
const AIM: f64 = 0.8;

/// Number of random directions that are tried at the end.
pub(crate) const TRIED: u64 = 2000;

/// Largest number of directions.
///
/// A distribution that jumps, for example where total reflection ends, would need any number of
/// them. A pair of ideal cubes needs 6 for a tolerance of 0.005.
const MOST_DIRECTIONS: usize = 1000;

/// Chooses the directions of `bake` for `tolerance` and returns the axes with them, and the largest
/// error of the last trials.
///
/// The exact method serves as the truth.
///
/// # Errors
/// Returns an [`Error`] if the greatest number of directions is too few, for example because the
/// distribution jumps, if the threads cannot be started, or if the caller stopped the search.
pub(crate) fn choose(
    bake: &Bake,
    exact: &ExactCell,
    tolerance: f64,
    progress: Progress<'_>,
) -> Result<(Axes, Option<Between>), Error> {
    let mut search = Search::new(bake, exact, tolerance);
    let largest = pool(bake.plan.threads)?.install(|| search.refine(progress))?;
    Ok((search.axes(bake.axes.bins), largest))
}

/// Search for the directions of a table.
struct Search<'a> {
    bake: &'a Bake<'a>,
    exact: &'a ExactCell,
    /// Total variation to reach in directions that are tried.
    aim: f64,
    incidences: Vec<f64>,
    azimuths: Vec<f64>,
    /// End of the gap after the last azimuth, degrees, where azimuths go all around.
    around_to: Option<f64>,
}

/// Direction to try, and the gaps that it lies in.
#[derive(Debug, Clone, Copy)]
struct Probe {
    incidence_deg: f64,
    azimuth_deg: f64,
    /// Number of the gap of incidences; `None` if the direction has an incidence of the table.
    along: Option<usize>,
    /// Number of the gap of azimuths; `None` if the direction has an azimuth of the table.
    across: Option<usize>,
}

impl<'a> Search<'a> {
    /// Makes a search that begins with the ends of the angles asked for.
    fn new(bake: &'a Bake<'a>, exact: &'a ExactCell, tolerance: f64) -> Self {
        let ends = |angles: &[f64]| match angles {
            [first, .., last] => vec![*first, *last],
            other => other.to_vec(),
        };
        let (first, width) = bake.symmetry.sector_deg();
        // Where azimuths go all around, the last gap ends at the first azimuth again.
        let goes_around = bake.plan.full_step_deg.is_some() && bake.symmetry.mirror_deg.is_none();
        Search {
            bake,
            exact,
            incidences: ends(&bake.axes.incidence_deg),
            azimuths: if goes_around {
                vec![first, first + 0.5 * width]
            } else {
                ends(&bake.axes.azimuth_deg)
            },
            around_to: goes_around.then_some(first + width),
            aim: AIM * tolerance,
        }
    }

    /// Returns the axes with the directions found so far and with `bins` bins.
    fn axes(&self, bins: usize) -> Axes {
        Axes {
            incidence_deg: self.incidences.clone(),
            azimuth_deg: self.azimuths.clone(),
            bins,
            range: self.bake.axes.range,
        }
    }

    /// Returns the azimuths, followed by the end of the last gap where azimuths go all around.
    ///
    /// So they do too where a table of a range of azimuths would be interpolated in that gap.
    fn azimuth_ends(&self) -> Vec<f64> {
        let full = self.bake.plan.full_step_deg.is_some();
        let bridged = !full && self.axes(1).goes_around();
        let around = bridged.then(|| self.azimuths[0] + 360.0);
        let end = self.around_to.or(around);
        self.azimuths.iter().copied().chain(end).collect()
    }

    /// Halves gaps until all directions that are tried are within the aim. Returns the largest
    /// error of the last trials, or `None` if there is one direction only.
    fn refine(&mut self, progress: Progress<'_>) -> Result<Option<Between>, Error> {
        loop {
            if progress.is_stopped() {
                return Err(Error::Stopped);
            }
            // Only polygons are interpolated, so one bin is enough for the table.
            let bake = Bake {
                axes: self.axes(1),
                ..self.bake.clone()
            };
            let table = bake.beams(self.exact, Progress::none())?;
            let mut found = self.errors(&table, self.middles());
            if worst(&found) <= self.aim {
                found.extend(self.errors(&table, self.random()));
            }
            if worst(&found) > self.aim {
                self.halve(&found)?;
                continue;
            }
            let largest = found.iter().max_by(|a, b| a.0.total_cmp(&b.0));
            return Ok(largest.map(|&(error, probe)| Between {
                error,
                incidence_deg: probe.incidence_deg,
                azimuth_deg: probe.azimuth_deg,
                tried: found.len(),
            }));
        }
    }

    /// Returns the middles of the cells between directions, and of the sides of these cells.
    fn middles(&self) -> Vec<Probe> {
        // A place is a value of the axis, without a gap, or the middle of a gap.
        let places = |ends: &[f64], values: usize| -> Vec<(f64, Option<usize>)> {
            let gaps = ends.windows(2).enumerate();
            let middles = gaps.map(|(gap, pair)| (0.5 * (pair[0] + pair[1]), Some(gap)));
            ends[..values]
                .iter()
                .map(|&x| (x, None))
                .chain(middles)
                .collect()
        };
        let along = places(&self.incidences, self.incidences.len());
        let across = places(&self.azimuth_ends(), self.azimuths.len());
        let mut probes = Vec::new();
        for &(incidence_deg, along) in &along {
            for &(azimuth_deg, across) in &across {
                if along.is_some() || across.is_some() {
                    probes.push(Probe {
                        incidence_deg,
                        azimuth_deg,
                        along,
                        across,
                    });
                }
            }
        }
        probes
    }

    /// Returns random directions, equal in all runs, so that the table does not depend on the seed.
    fn random(&self) -> Vec<Probe> {
        let stream = Stream::new(Sampler::Random, default::SEED, 0.0, 0.0, 0);
        let between = |ends: &[f64], share: u32| match ends {
            [first, .., last] => {
                let x = first + (last - first) * (f64::from(share) + 0.5) / 2_f64.powi(32);
                let above = ends.partition_point(|&end| end <= x);
                (x, Some(above.clamp(1, ends.len() - 1) - 1))
            }
            only => (only[0], None),
        };
        let azimuths = self.azimuth_ends();
        (0..TRIED)
            .map(|index| {
                let [a, b] = stream.pair(index);
                let (incidence_deg, along) = between(&self.incidences, a);
                let (azimuth_deg, across) = between(&azimuths, b);
                Probe {
                    incidence_deg,
                    azimuth_deg,
                    along,
                    across,
                }
            })
            .collect()
    }

    /// Returns the error of each direction to try.
    fn errors(&self, table: &Table, probes: Vec<Probe>) -> Vec<(f64, Probe)> {
        let error = |probe: Probe| {
            let (incidence, azimuth) = (probe.incidence_deg, probe.azimuth_deg);
            let found = error_at(self.exact, &self.bake.rules, table, incidence, azimuth);
            (found, probe)
        };
        probes.into_par_iter().map(error).collect()
    }

    /// Halves the gaps with errors above the tolerance.
    ///
    /// It takes only gaps with more than half the worst error at a time, because halving one gap
    /// may help many others.
    fn halve(&mut self, found: &[(f64, Probe)]) -> Result<(), Error> {
        let azimuths = self.azimuth_ends();
        let mut errors = [
            vec![0.0_f64; self.incidences.len() - 1],
            vec![0.0_f64; azimuths.len() - 1],
        ];
        let raise =
            |errors: &mut [f64], gap: usize, error: f64| errors[gap] = errors[gap].max(error);
        // The error of a direction in one gap only belongs to that gap.
        for (error, probe) in found {
            match (probe.along, probe.across) {
                (Some(gap), None) => raise(&mut errors[0], gap, *error),
                (None, Some(gap)) => raise(&mut errors[1], gap, *error),
                _ => {}
            }
        }
        // The error of a direction in two gaps belongs to the gap that is worse by itself. If both
        // are equal, it belongs to the wider one.
        let sides = errors.clone();
        for (error, probe) in found.iter().filter(|(error, _)| *error > self.aim) {
            let (Some(along), Some(across)) = (probe.along, probe.across) else {
                continue;
            };
            let (a, b) = (sides[0][along], sides[1][across]);
            if a.max(b) > self.aim {
                continue;
            }
            let widths =
                [&self.incidences[along..], &azimuths[across..]].map(|ends| ends[1] - ends[0]);
            let along_is_worse = if a == b { widths[0] > widths[1] } else { a > b };
            if along_is_worse {
                raise(&mut errors[0], along, *error);
            } else {
                raise(&mut errors[1], across, *error);
            }
        }
        let worst = errors.iter().flatten().copied().fold(0.0, f64::max);
        let least = self.aim.max(0.5 * worst);
        let known = found
            .iter()
            .filter(|(error, _)| (self.aim..OPEN).contains(error));
        let worst = known
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .or_else(|| found.iter().find(|(error, _)| *error == OPEN));
        if let Some((reached, probe)) = worst
            && self.incidences.len() * self.azimuths.len() > MOST_DIRECTIONS
        {
            let still = match *reached < OPEN {
                true => format!(
                    "the error is still {reached:.3e}, above the {:.3e} that the search aims at \
                    because it tries only some of all directions,",
                    self.aim
                ),
                false => "the polygons can still not be interpolated".into(),
            };
            return Err(Error::Failed(format!(
                "--direction-tolerance: with {MOST_DIRECTIONS} directions {still} at incidence {} \
                deg, azimuth {} deg; ray shifts may jump there, for example because total \
                reflection ends or slits of a plate change places; leave out such angles, or give \
                a greater tolerance",
                probe.incidence_deg, probe.azimuth_deg
            )));
        }
        self.insert(errors.map(|axis| axis.iter().map(|&error| error > least).collect()));
        Ok(())
    }

    /// Adds the middles of the gaps marked, of incidences and of azimuths.
    fn insert(&mut self, marked: [Vec<bool>; 2]) {
        let ends = [self.incidences.clone(), self.azimuth_ends()];
        let axes = [&mut self.incidences, &mut self.azimuths];
        for ((axis, ends), marked) in axes.into_iter().zip(ends).zip(marked) {
            let gaps = ends.windows(2).zip(marked);
            let halved = gaps.filter(|(_, marked)| *marked);
            axis.extend(halved.map(|(gap, _)| 0.5 * (gap[0] + gap[1])));
            axis.sort_by(f64::total_cmp);
        }
    }
}

/// Returns the greatest error.
fn worst(found: &[(f64, Probe)]) -> f64 {
    found.iter().map(|(error, _)| *error).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::Prepared;
    use crate::plan::{Plan, Request};
    use meshes::design::{Design, Shape};

    /// An error between the aim and the tolerance is refused by the aim, and that is said.
    #[test]
    fn an_error_above_the_aim_is_refused_by_the_aim() {
        let mesh = Design::new(Shape::Triangular).mesh().expect("a mesh");
        let cell = meshes::normalise(&mesh, "cell.obj".as_ref(), &meshes::CellOptions::default());
        let plan = Plan::new(&Request::default()).expect("a valid request");
        let prepared = Prepared::new(cell.expect("a cell"));
        let exact = prepared.exact().expect("planar");
        let bake = Bake::new(&prepared, &plan, Progress::none()).expect("a bake");
        let mut search = Search::new(&bake, exact, 0.02);
        search.incidences = (0..=MOST_DIRECTIONS).map(|k| 0.04 * k as f64).collect();
        search.azimuths = vec![0.0];
        let probe = Probe {
            incidence_deg: 0.02,
            azimuth_deg: 0.0,
            along: Some(0),
            across: None,
        };
        let refused = search.halve(&[(0.0167, probe)]).expect_err("too many");
        let said = refused.to_string();
        assert!(
            said.contains("1.670e-2") && said.contains("1.600e-2"),
            "{said}"
        );
    }
}
