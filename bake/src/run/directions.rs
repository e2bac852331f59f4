//! Directions chosen so that a table says what lies between them to a tolerance.
//!
//! The distance of two distributions is the total variation of eta x histogram. Beginning with the
//! ends of the angles asked for, the gaps between incidences and between azimuths are halved where
//! the table, asked for the middle, is further than the tolerance from what the exact method finds
//! there; at last at random directions too. So the directions lie close where paths end or lose a
//! corner, and far apart elsewhere.

use crate::beams::exact;
use crate::cell::ExactCell;
use crate::plan::default;
use crate::run::bake::Bake;
use crate::run::error::RunError;
use crate::run::watch::Watch;
use crate::samples::Stream;
use rayon::prelude::*;
use tables::cli::pool;
use tables::options::Sampler;
use tables::{Axes, Fate, Table};

/// Part of the tolerance that is aimed at, since some directions are tried for all.
const AIM: f64 = 0.8;

/// Random directions that are tried at last.
pub(crate) const TRIED: u64 = 2000;

/// Directions at most. A distribution that jumps, as where total reflection ends, asks for any
/// number of them; a pair of ideal cubes takes 6 for a tolerance of 0.005.
const MOST_DIRECTIONS: usize = 1000;

/// The axes of `bake` with directions chosen for `tolerance`, by what the exact method finds.
///
/// # Errors
/// [`RunError::DirectionTolerance`] where the distribution jumps.
pub(crate) fn choose(bake: &Bake, exact: &ExactCell, tolerance: f64) -> Result<Axes, RunError> {
    let ends = |angles: &[f64]| match angles {
        [first, .., last] => vec![*first, *last],
        other => other.to_vec(),
    };
    let (first, width) = bake.symmetry.sector_deg();
    // Where azimuths go all around, the last gap ends at the first azimuth again.
    let goes_around = bake.plan.full_step_deg.is_some() && bake.symmetry.mirror_deg.is_none();
    let mut search = Search {
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
    };
    pool(bake.plan.threads)?.install(|| search.refine())?;
    Ok(search.axes(bake.axes.bins))
}

struct Search<'a> {
    bake: &'a Bake<'a>,
    exact: &'a ExactCell,
    /// Total variation to reach.
    aim: f64,
    incidences: Vec<f64>,
    azimuths: Vec<f64>,
    /// Where the gap after the last azimuth ends.
    around_to: Option<f64>,
}

/// A direction to try, and the gaps that it lies in.
#[derive(Debug, Clone, Copy)]
struct Probe {
    incidence_deg: f64,
    azimuth_deg: f64,
    /// Gap of incidences.
    along: Option<usize>,
    /// Gap of azimuths.
    across: Option<usize>,
}

impl Search<'_> {
    fn axes(&self, bins: usize) -> Axes {
        Axes {
            incidence_deg: self.incidences.clone(),
            azimuth_deg: self.azimuths.clone(),
            bins,
            range: self.bake.axes.range,
        }
    }

    /// Azimuths with the end of the last gap.
    fn azimuth_ends(&self) -> Vec<f64> {
        self.azimuths
            .iter()
            .copied()
            .chain(self.around_to)
            .collect()
    }

    fn refine(&mut self) -> Result<(), RunError> {
        loop {
            // Polygons alone are interpolated, so that the table needs no bins.
            let bake = Bake {
                axes: self.axes(1),
                ..self.bake.clone()
            };
            let table = bake.beams(self.exact, Watch::none())?;
            let mut found = self.errors(&table, self.middles());
            if worst(&found) <= self.aim {
                found = self.errors(&table, self.random());
                if worst(&found) <= self.aim {
                    return Ok(());
                }
            }
            self.halve(&found)?;
        }
    }

    /// The middles of the cells and of their sides.
    fn middles(&self) -> Vec<Probe> {
        // Even places are values of the axis, odd ones middles of gaps.
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

    /// Directions anywhere, always the same ones: the table does not depend on the seed.
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

    fn errors(&self, table: &Table, probes: Vec<Probe>) -> Vec<(f64, Probe)> {
        let error = |probe: Probe| (self.error(table, &probe), probe);
        probes.into_par_iter().map(error).collect()
    }

    /// Total variation between what the table says and the truth.
    fn error(&self, table: &Table, probe: &Probe) -> f64 {
        let (incidence, azimuth) = (probe.incidence_deg, probe.azimuth_deg);
        let paths = table
            .direction(incidence, Some(azimuth))
            .ok()
            .and_then(|found| found.paths);
        // Polygons that cannot be interpolated say nothing.
        let Some(paths) = paths else { return 1.0 };
        // Whatever the bins of the table, so that a tolerance means one thing.
        let (bins, range) = (default::BINS, default::RANGE);
        let truth = self
            .exact
            .direction(incidence, azimuth, bins, range, &self.bake.rules);
        let (mass, outside) = exact::spread(&paths, self.exact.entrance_area(), bins, range);
        let bins = mass
            .iter()
            .zip(&truth.histogram)
            .map(|(a, b)| (a - b).abs());
        0.5 * (bins.sum::<f64>() + (outside - truth.fate[Fate::OutOfRange as usize]).abs())
    }

    /// Halves the gaps with errors above the tolerance, the worst half of them at a time, so that
    /// one may do for many.
    fn halve(&mut self, found: &[(f64, Probe)]) -> Result<(), RunError> {
        let azimuths = self.azimuth_ends();
        let mut errors = [
            vec![0.0_f64; self.incidences.len() - 1],
            vec![0.0_f64; azimuths.len() - 1],
        ];
        let raise =
            |errors: &mut [f64], gap: usize, error: f64| errors[gap] = errors[gap].max(error);
        // What lies in one gap only is that gap's.
        for (error, probe) in found {
            match (probe.along, probe.across) {
                (Some(gap), None) => raise(&mut errors[0], gap, *error),
                (None, Some(gap)) => raise(&mut errors[1], gap, *error),
                _ => {}
            }
        }
        // Of two gaps the one is to blame that is worse by itself; without a difference, the wider
        // one.
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
        let worst = found.iter().max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((reached, probe)) = worst
            && self.incidences.len() * self.azimuths.len() > MOST_DIRECTIONS
        {
            return Err(RunError::DirectionTolerance {
                incidence_deg: probe.incidence_deg,
                azimuth_deg: probe.azimuth_deg,
                reached: *reached,
                directions: MOST_DIRECTIONS,
            });
        }
        for (which, ends) in [(0, self.incidences.clone()), (1, azimuths)] {
            let axis = if which == 0 {
                &mut self.incidences
            } else {
                &mut self.azimuths
            };
            let wide = errors[which].iter().enumerate();
            for (gap, _) in wide.filter(|(_, error)| **error > least) {
                axis.push(0.5 * (ends[gap] + ends[gap + 1]));
            }
            axis.sort_by(f64::total_cmp);
        }
        Ok(())
    }
}

fn worst(found: &[(f64, Probe)]) -> f64 {
    found.iter().map(|(error, _)| *error).fold(0.0, f64::max)
}
