//! Study of speed and error: plans the bakes, runs them, and compares each with the exact table.
//!
//! The error of a direction is the L1 distance of eta x histogram, in probability per launched ray
//! ([`tables::l1`]). The seconds are those of a whole bake of all directions, from the loaded cell
//! to the table in memory, including the start of the threads. Every repeat has its own seed.
//! Errors are means over these independent samples, and seconds are medians.

use crate::error::Error;
use crate::study::fit;
use crate::study::fit::density;
pub(crate) use crate::study::fit::estimates;

use crate::beams::exact;
use crate::cell::Prepared;
use crate::plan;
use crate::plan::{Plan, request};
use crate::rays::{Bins, Index, Kernel, Sheet, Tracer};
use crate::run::{Bake, Progress, trace};
use crate::study::fit::{Reached, Slope};
use meshes::Cell;
use std::time::Instant;
use tables::Table;
use tables::options::{Method, Sampler};

/// Smallest number of rays per direction; the other numbers are its products with powers of 4.
pub(crate) const FEWEST_RAYS: u64 = 1 << 10;

/// Ratio of the rays of the reference to the largest number studied, if a cell has no exact table.
///
/// At the slope of -3/4, the error of the reference is then a third of the smallest one measured.
const REFERENCE_RAYS: u64 = 4;

/// Largest number of repeats.
const MOST_REPEATS: usize = 1000;

/// Smallest number of rays per bin that any ray met, in each randomisation, of a fitted point.
///
/// With fewer rays, a bin is met or not, and the error falls slower. The mean absolute error of 4
/// random rays is 2 % below its limit.
const RAYS_PER_BIN: f64 = 4.0;

/// Smallest ratio of a fitted point's error to the error of the reference.
///
/// Independent errors add in squares, so a point at this ratio is 5 % too large.
const ABOVE_REFERENCE: f64 = 3.0;

/// Defaults of those options of `bake study` that `bake trace` does not have.
pub(crate) mod default {
    /// Bakes of each kind (`--repeats`).
    pub(crate) const REPEATS: usize = 3;
    /// L1 error (`--target`) that 16.8 million random rays per direction reach on 128 x 128 bins.
    pub(crate) const TARGET: f64 = 0.008;
    /// Longest expected time of a bake, seconds (`--longest`).
    pub(crate) const LONGEST_SECONDS: f64 = 60.0;
}

/// Request for a study, before it is checked.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyRequest {
    /// Directions, bins, rules, threads, first seed, and in `rays` the largest number of rays per
    /// direction. Method, sampler and tolerance have no effect.
    pub trace: request::Request,
    /// Bakes of each kind.
    pub repeats: usize,
    /// L1 error of the worst direction for which the time is reported; above 0, at most 2.
    pub target: f64,
    /// Longest expected time of a bake, seconds.
    ///
    /// A bake that is expected to take longer is left out, and so are those with more rays.
    pub longest_seconds: f64,
}

/// Table against which the errors are measured.
#[derive(Debug, Clone, PartialEq)]
pub enum Reference {
    /// Exact table, which has no error but rounding.
    Exact {
        /// Median time of the exact bake, seconds.
        seconds: f64,
    },
    /// Table of more Sobol rays, if the exact method does not take the cell.
    Sobol {
        /// Rays per direction of the reference.
        rays: u64,
        /// Estimated L1 error of the reference in its worst direction.
        ///
        /// Points whose error is not well above it are left out of the fitted slopes.
        estimated_l1: f64,
        /// Reason why there is no exact table.
        refusal: String,
    },
}

/// Measurement of the bakes of one number of rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StudyPoint {
    /// Rays per direction.
    pub rays: u64,
    /// Median time of the bake, seconds.
    pub seconds: f64,
    /// L1 error, mean over directions and repeats.
    pub l1: f64,
    /// L1 error of the worst direction, mean over repeats.
    pub worst_l1: f64,
    /// Estimate of `l1` from the tables alone, by the method of `--tolerance`.
    pub estimated_l1: f64,
    /// Largest estimated L1 error of any direction, mean over repeats.
    ///
    /// `--tolerance` compares the same number with its target.
    pub worst_estimated_l1: f64,
    /// Retroreflected rays per bin that any ray met, in one randomisation.
    ///
    /// It is the least over the directions that return light, and over the repeats.
    pub rays_per_bin: f64,
}

impl StudyPoint {
    /// Returns the true error over the estimated error; NaN if nothing returned.
    pub fn ratio(&self) -> f64 {
        self.l1 / self.estimated_l1
    }
}

/// Measurements of one tracer and one sampler, at every number of rays.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Tracer of the rays.
    pub tracer: Tracer,
    /// Sampler of the rays.
    pub sampler: Sampler,
    /// Measurements, in ascending numbers of rays.
    pub points: Vec<StudyPoint>,
    /// Power law of `l1` against rays; `None` if fewer than two points can be used.
    ///
    /// A point is used if it has enough rays per bin and its error is well above the reference's.
    pub slope: Option<Slope>,
    /// Time at which the error of the worst direction falls to the target.
    pub reached: Reached,
}

/// Result of a study: all measurements, and what they were made on.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// Name of the cell's design.
    pub design: String,
    /// Directions of each table.
    pub directions: usize,
    /// Number of directions that run as programs.
    ///
    /// In them, [`Tracer::Fastest`] differs from [`Tracer::OneByOne`].
    pub programs: usize,
    /// `true` if each direction is a mean over all azimuths.
    pub azimuth_mean: bool,
    /// Bins along u and along v.
    pub bins: usize,
    /// Number of threads; `None` for all processors.
    pub threads: Option<usize>,
    /// Bakes of each kind.
    pub repeats: usize,
    /// L1 error of the worst direction for which the time is reported.
    pub target: f64,
    /// Table against which the errors are measured.
    pub reference: Reference,
    /// Measurements of rays, one series for each tracer and sampler.
    pub series: Vec<Series>,
}

/// Returns the rays per direction to study: [`FEWEST_RAYS`] times powers of 4, up to `most`.
pub(crate) fn ray_counts(most: u64) -> Vec<u64> {
    let next = |&rays: &u64| rays.checked_mul(4).filter(|&rays| rays <= most);
    std::iter::successors(Some(FEWEST_RAYS).filter(|&rays| rays <= most), next).collect()
}

/// Study whose options are in range.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyPlan {
    request: StudyRequest,
    counts: Vec<u64>,
}

impl StudyPlan {
    /// Checks a request.
    ///
    /// # Errors
    /// Returns [`Error::Usage`] for the first option that is out of range.
    pub fn new(request: StudyRequest) -> Result<Self, Error> {
        let StudyRequest {
            repeats, target, ..
        } = request;
        if !(1..=MOST_REPEATS).contains(&repeats) {
            return Err(Error::Usage(format!(
                "--repeats {repeats}: give a whole number from 1 to {MOST_REPEATS}"
            )));
        }
        if !(target > 0.0 && target <= 2.0) {
            return Err(Error::Usage(format!(
                "--target {target}: give a number above 0 and at most 2, the greatest L1 distance"
            )));
        }
        let seconds = request.longest_seconds;
        if seconds.is_nan() || seconds <= 0.0 {
            return Err(Error::Usage(format!(
                "--longest {seconds}: give a number of seconds above 0"
            )));
        }
        let rays = request.trace.rays.unwrap_or(plan::default::RAYS);
        let counts = ray_counts(rays);
        let Some(&most) = counts.last() else {
            return Err(Error::Usage(format!(
                "--rays {rays}: a study begins with {FEWEST_RAYS} rays per direction; give at \
                least that many"
            )));
        };
        let checked = StudyPlan { request, counts };
        checked.plan(Sampler::Random, most, 0)?;
        checked.plan(Sampler::Sobol, most.saturating_mul(REFERENCE_RAYS), 0)?;
        Ok(checked)
    }

    /// Plans the bake of one repeat, whose seed is the first seed plus `repeat`.
    fn plan(&self, sampler: Sampler, rays: u64, repeat: usize) -> Result<Plan, Error> {
        Plan::new(&request::Request {
            method: Method::Rays,
            sampler,
            rays: Some(rays),
            tolerance: None,
            seed: self.request.trace.seed.wrapping_add(repeat as u64),
            ..self.request.trace.clone()
        })
    }

    /// Runs all bakes of the study and fits the slopes.
    ///
    /// Before the reference, and before the bakes of each number of rays, calls `done` with the
    /// name of what comes next, the number of steps that are done, and the number of all steps.
    ///
    /// # Errors
    /// Returns an [`Error`] if a bake fails, or if an option is out of range.
    pub fn run(&self, cell: &Cell, done: &dyn Fn(&str, usize, usize)) -> Result<Study, Error> {
        let most = self.counts[self.counts.len() - 1];
        let plan = self.plan(Sampler::Sobol, most, 0)?;
        let programs = programs(&Prepared::new(cell.clone()), &plan);
        let mut tracers = vec![Tracer::Fastest, Tracer::OneByOne];
        if programs == 0 {
            tracers.remove(0);
        }
        let bakes = 1 + tracers.len() * 2 * self.counts.len();
        done("reference", 0, bakes);
        let (table, reference) = self.reference(cell, &plan)?;
        let floor = match reference {
            Reference::Exact { .. } => 0.0,
            Reference::Sobol { estimated_l1, .. } => estimated_l1,
        };
        // The first bake of a process is slower because it allocates memory, so it is not timed.
        bake(cell, &self.plan(Sampler::Sobol, FEWEST_RAYS, 0)?)?;
        let mut series = Vec::new();
        for tracer in tracers {
            for sampler in [Sampler::Random, Sampler::Sobol] {
                let mut points: Vec<StudyPoint> = Vec::new();
                for &rays in &self.counts {
                    let expected = points.last().map_or(0.0, |point| 4.0 * point.seconds);
                    if expected > self.request.longest_seconds {
                        break;
                    }
                    let at = 1 + series.len() * self.counts.len() + points.len();
                    done(
                        &format!("{}, {}, {rays} rays", name(tracer), sampler.name()),
                        at,
                        bakes,
                    );
                    points.push(self.point(cell, &table, tracer, sampler, rays)?);
                }
                let usable = |point: &&StudyPoint| {
                    point.rays_per_bin >= RAYS_PER_BIN && point.l1 > ABOVE_REFERENCE * floor
                };
                let dense: Vec<[f64; 2]> = points
                    .iter()
                    .filter(usable)
                    .map(|point| [point.rays as f64, point.l1])
                    .collect();
                let times: Vec<[f64; 2]> = points
                    .iter()
                    .map(|point| [point.seconds, point.worst_l1])
                    .collect();
                series.push(Series {
                    tracer,
                    sampler,
                    slope: fit::slope(&dense),
                    reached: fit::reached(&times, self.request.target),
                    points,
                });
            }
        }
        Ok(Study {
            design: cell.design.clone(),
            directions: plan.axes.incidence_deg.len() * plan.axes.azimuth_deg.len(),
            programs,
            azimuth_mean: plan.is_azimuth_mean(),
            bins: plan.axes.bins,
            threads: plan.threads.map(|threads| threads.get()),
            repeats: self.request.repeats,
            target: self.request.target,
            reference,
            series,
        })
    }

    /// Bakes the reference: the exact table and its time, or a table of more rays.
    fn reference(&self, cell: &Cell, plan: &Plan) -> Result<(Table, Reference), Error> {
        if let Err(refusal) = exact::prepare(&Prepared::new(cell.clone()), &plan.axes) {
            let most = self.counts[self.counts.len() - 1];
            let rays = most * REFERENCE_RAYS;
            let mut plan = self.plan(Sampler::Sobol, rays, 0)?;
            // The reference has a seed of its own. With the samples of a studied table it would
            // share the error of that table.
            plan.seed = self.request.trace.seed.wrapping_sub(1);
            let table = bake(cell, &plan)?;
            let estimated_l1 = estimates(&table).into_iter().fold(0.0, f64::max);
            let reference = Reference::Sobol {
                rays,
                estimated_l1,
                refusal,
            };
            return Ok((table, reference));
        }
        let plan = Plan {
            method: Method::Exact,
            ..plan.clone()
        };
        let mut seconds = Vec::new();
        let mut table = bake(cell, &plan)?;
        for _ in 0..self.request.repeats {
            let start = Instant::now();
            table = bake(cell, &plan)?;
            seconds.push(start.elapsed().as_secs_f64());
        }
        let seconds = fit::median(&mut seconds);
        Ok((table, Reference::Exact { seconds }))
    }

    /// Bakes every repeat with one number of rays and measures its time and its errors.
    fn point(
        &self,
        cell: &Cell,
        reference: &Table,
        tracer: Tracer,
        sampler: Sampler,
        rays: u64,
    ) -> Result<StudyPoint, Error> {
        let repeats = self.request.repeats;
        let mut seconds = Vec::with_capacity(repeats);
        let mut errors = vec![0.0; reference.retroreflected.len()];
        let (mut estimated_l1, mut worst_estimated_l1) = (0.0, 0.0);
        let mut rays_per_bin = f64::INFINITY;
        for repeat in 0..repeats {
            let plan = self.plan(sampler, rays, repeat)?;
            let start = Instant::now();
            let prepared = Prepared::new(cell.clone());
            let table = Bake::new(&prepared, &plan, Progress::none())?
                .by(tracer)
                .table(Progress::none())?;
            seconds.push(start.elapsed().as_secs_f64());
            let share = 1.0 / repeats as f64;
            let distances = tables::l1(&table, reference);
            errors
                .iter_mut()
                .zip(&distances)
                .for_each(|(sum, l1)| *sum += l1 * share);
            let estimates = estimates(&table);
            estimated_l1 += estimates.iter().sum::<f64>() / estimates.len() as f64 * share;
            worst_estimated_l1 += estimates.into_iter().fold(0.0, f64::max) * share;
            rays_per_bin = rays_per_bin.min(density(&table));
        }
        Ok(StudyPoint {
            rays,
            seconds: fit::median(&mut seconds),
            l1: errors.iter().sum::<f64>() / errors.len() as f64,
            worst_l1: errors.into_iter().fold(0.0, f64::max),
            estimated_l1,
            worst_estimated_l1,
            rays_per_bin,
        })
    }
}

/// Bakes a cell, which is dissected anew because the measured seconds include that.
fn bake(cell: &Cell, plan: &Plan) -> Result<Table, Error> {
    trace(&Prepared::new(cell.clone()), plan, Progress::none())
}

/// Returns the name of a tracer in reports.
pub(crate) fn name(tracer: Tracer) -> &'static str {
    match tracer {
        Tracer::Fastest => "program",
        Tracer::OneByOne => "one by one",
    }
}

/// Counts the directions that run as programs.
fn programs(prepared: &Prepared, plan: &Plan) -> usize {
    let sheet = Sheet::new(prepared, Index::Auto);
    let bins = Bins::new(plan.axes.bins, plan.axes.range);
    let rules = plan.rules(prepared.cell());
    plan.axes
        .directions()
        .filter(|&(i, a)| {
            !Kernel::over(&sheet, &rules, &bins, i, a)
                .programs()
                .is_empty()
        })
        .count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ray_counts_are_powers_of_four() {
        assert!(ray_counts(1023).is_empty());
        assert_eq!(ray_counts(1024), [1024]);
        assert_eq!(ray_counts(70_000), [1024, 4096, 16_384, 65_536]);
        assert_eq!(ray_counts(u64::MAX).len(), 27);
    }

    #[test]
    fn bad_options_name_option_value_and_remedy() {
        let with = |rays, repeats, target| {
            let trace = request::Request {
                rays: Some(rays),
                ..request::Request::default()
            };
            StudyPlan::new(StudyRequest {
                trace,
                repeats,
                target,
                longest_seconds: default::LONGEST_SECONDS,
            })
            .expect_err("out of range")
            .to_string()
        };
        assert!(with(1000, 3, 0.008).starts_with("--rays 1000: a study begins with 1024"));
        assert!(with(4096, 0, 0.008).starts_with("--repeats 0: give a whole number from 1"));
        assert!(with(4096, 3, f64::NAN).starts_with("--target NaN: give a number above 0"));
        assert!(with(1 << 36, 3, 0.008).starts_with("--rays 274877906944: give a whole number"));
    }
}
