//! Speed against error: every method, sampler and number of rays on one cell, against the exact
//! table.
//!
//! The error is L1 on eta x histogram, probability per launched ray ([`tables::l1`]), of every
//! direction; seconds are those of a whole bake from the loaded cell to the table in memory, all
//! directions, start of the threads included. Every repeat has its own seed, so that errors are
//! averaged over independent samples and seconds are medians.

use crate::study::counted::density;
pub(crate) use crate::study::counted::estimates;
use crate::study::fit;

use crate::beams::exact;
use crate::cell::{ExactError, Prepared};
use crate::plan;
use crate::plan::{Plan, PlanError, request};
use crate::rays::{Bins, Index, Kernel, Sheet, Tracer};
use crate::run::{Bake, RunError, Watch, trace};
use crate::study::fit::{Reached, Slope};
use meshes::Cell;
use std::time::Instant;
use tables::Table;
use tables::options::{Method, Sampler};
use thiserror::Error;

/// The smallest number of rays per direction; the next ones are its products with powers of 4.
pub(crate) const FEWEST_RAYS: u64 = 1 << 10;

/// Rays of the reference over the largest number studied, where a cell has no exact table: at the
/// slope of -3/4 its error is then a third of the smallest one measured.
const REFERENCE_RAYS: u64 = 4;

/// Repeats at most.
const MOST_REPEATS: usize = 1000;

/// Rays per histogram bin that is met, in each randomisation, from which on a slope is fitted:
/// below, a bin is met or not, and the error falls slower (the mean absolute error of 4 random rays
/// is 2 % below its limit).
const RAYS_PER_BIN: f64 = 4.0;

/// Errors below this many times the reference's own are left out of a slope: independent errors add
/// in squares, so that the greatest one left in is 5 % too large.
const ABOVE_REFERENCE: f64 = 3.0;

/// Defaults of `bake study` that are not those of `bake trace`.
pub(crate) mod default {
    /// `--repeats`
    pub(crate) const REPEATS: usize = 3;
    /// `--target`, L1: what 16.8 million random rays a direction reach on 128 x 128 bins.
    pub(crate) const TARGET: f64 = 0.008;
    /// `--longest`, s
    pub(crate) const LONGEST_SECONDS: f64 = 60.0;
}

/// What to study.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyRequest {
    /// Directions, bins, rules, threads and first seed; its `rays` is the greatest number per
    /// direction, its method, sampler and tolerance have no effect.
    pub trace: request::Request,
    /// Bakes of each kind.
    pub repeats: usize,
    /// L1 error of the worst direction that the time is asked for.
    pub target: f64,
    /// A bake that is expected to take longer than this, s, is left out, and all with more rays.
    pub longest_seconds: f64,
}

/// Why a study failed.
#[derive(Debug, Error)]
pub enum StudyError {
    /// The options are out of range.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Too few rays to begin.
    #[error(
        "--rays {rays}: a study begins with {FEWEST_RAYS} rays per direction; give at least that \
        many"
    )]
    FewRays {
        /// The number given.
        rays: u64,
    },
    /// No repeats, or too many.
    #[error("--repeats {repeats}: give a whole number from 1 to {MOST_REPEATS}")]
    Repeats {
        /// The number given.
        repeats: usize,
    },
    /// A target that is no L1 distance.
    #[error("--target {target}: give a number above 0 and at most 2, the greatest L1 distance")]
    Target {
        /// The number given.
        target: f64,
    },
    /// A time that no bake can keep.
    #[error("--longest {seconds}: give a number of seconds above 0")]
    Longest {
        /// The number given.
        seconds: f64,
    },
    /// A bake failed.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// What the errors are measured against.
#[derive(Debug, Clone, PartialEq)]
pub enum Reference {
    /// The exact table: no error but rounding.
    Exact {
        /// Median time of the exact bake, s.
        seconds: f64,
    },
    /// A table of more Sobol rays, where the exact method does not take the cell.
    Sobol {
        /// Its rays per direction.
        rays: u64,
        /// Its own estimated L1 error in the worst direction: errors below some times this are not
        /// measured.
        estimated_l1: f64,
        /// Why there is no exact table.
        refusal: ExactError,
    },
}

/// Bakes of one number of rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Rays per direction.
    pub rays: u64,
    /// Median time of the bake, s.
    pub seconds: f64,
    /// L1 error, mean over directions and repeats.
    pub l1: f64,
    /// L1 error of the worst direction, mean over repeats.
    pub worst_l1: f64,
    /// Estimate of `l1` from the tables alone, as `--tolerance` makes it.
    pub estimated_l1: f64,
    /// Estimate of the L1 error of the direction with the largest estimate, mean over repeats: what
    /// `--tolerance` compares.
    pub worst_estimated_l1: f64,
    /// Returned rays per bin that any ray met, in one randomisation; the least over directions that
    /// return light.
    pub rays_per_bin: f64,
}

impl Point {
    /// True error over estimated error; not a number where nothing returned.
    pub fn ratio(&self) -> f64 {
        self.l1 / self.estimated_l1
    }
}

/// One way to trace and to sample, at every number of rays.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// How rays are traced.
    pub tracer: Tracer,
    /// How samples are spread.
    pub sampler: Sampler,
    /// In ascending numbers of rays.
    pub points: Vec<Point>,
    /// Exponent of `l1` against rays, over the points with enough rays per bin and well above the
    /// error of the reference; `None` for fewer than two of them.
    pub slope: Option<Slope>,
    /// When the worst direction's error falls to the target.
    pub reached: Reached,
}

/// All that was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// Name of the cell's design.
    pub design: String,
    /// Directions of each table.
    pub directions: usize,
    /// Directions of these that run as programs: [`Tracer::Fastest`] differs from
    /// [`Tracer::OneByOne`] in them.
    pub programs: usize,
    /// Whether each is a mean over all azimuths.
    pub azimuth_mean: bool,
    /// Bins along u and along v.
    pub bins: usize,
    /// Threads; `None` for all processors.
    pub threads: Option<usize>,
    /// Bakes of each kind.
    pub repeats: usize,
    /// L1 error that the time was asked for.
    pub target: f64,
    /// What the errors are measured against.
    pub reference: Reference,
    /// The rays.
    pub series: Vec<Series>,
}

/// The numbers of rays per direction up to `most`: products of [`FEWEST_RAYS`] with powers of 4.
pub(crate) fn ray_counts(most: u64) -> Vec<u64> {
    let next = |&rays: &u64| rays.checked_mul(4).filter(|&rays| rays <= most);
    std::iter::successors(Some(FEWEST_RAYS).filter(|&rays| rays <= most), next).collect()
}

/// A study whose options are in range.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyPlan {
    request: StudyRequest,
    counts: Vec<u64>,
}

impl StudyPlan {
    /// Checks a request.
    ///
    /// # Errors
    /// [`StudyError`], all but [`StudyError::Run`].
    pub fn new(request: StudyRequest) -> Result<Self, StudyError> {
        let StudyRequest {
            repeats, target, ..
        } = request;
        if !(1..=MOST_REPEATS).contains(&repeats) {
            return Err(StudyError::Repeats { repeats });
        }
        if !(target > 0.0 && target <= 2.0) {
            return Err(StudyError::Target { target });
        }
        let seconds = request.longest_seconds;
        if seconds.is_nan() || seconds <= 0.0 {
            return Err(StudyError::Longest { seconds });
        }
        let rays = request.trace.rays.unwrap_or(plan::default::RAYS);
        let counts = ray_counts(rays);
        let Some(&most) = counts.last() else {
            return Err(StudyError::FewRays { rays });
        };
        let checked = StudyPlan { request, counts };
        checked.plan(Sampler::Random, most, 0)?;
        checked.plan(Sampler::Sobol, most.saturating_mul(REFERENCE_RAYS), 0)?;
        Ok(checked)
    }

    /// The plan of repeat `repeat`.
    fn plan(&self, sampler: Sampler, rays: u64, repeat: usize) -> Result<Plan, PlanError> {
        Plan::new(&request::Request {
            method: Method::Rays,
            sampler,
            rays: Some(rays),
            tolerance: None,
            seed: self.request.trace.seed.wrapping_add(repeat as u64),
            ..self.request.trace.clone()
        })
    }

    /// Bakes everything; `done` is told what comes next, how many bakes were done and of how many.
    ///
    /// # Errors
    /// [`StudyError`].
    pub fn run(&self, cell: &Cell, done: &dyn Fn(&str, usize, usize)) -> Result<Study, StudyError> {
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
        // The first bake of a process pays for its memory: it is not timed.
        bake(cell, &self.plan(Sampler::Sobol, FEWEST_RAYS, 0)?)?;
        let mut series = Vec::new();
        for tracer in tracers {
            for sampler in [Sampler::Random, Sampler::Sobol] {
                let mut points: Vec<Point> = Vec::new();
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
                let usable = |point: &&Point| {
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

    fn reference(&self, cell: &Cell, plan: &Plan) -> Result<(Table, Reference), StudyError> {
        if let Err(refusal) = exact::prepare(&Prepared::new(cell.clone()), &plan.axes) {
            let most = self.counts[self.counts.len() - 1];
            let rays = most * REFERENCE_RAYS;
            let mut plan = self.plan(Sampler::Sobol, rays, 0)?;
            // A seed of its own: with the samples of a table it would share that table's error.
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

    fn point(
        &self,
        cell: &Cell,
        reference: &Table,
        tracer: Tracer,
        sampler: Sampler,
        rays: u64,
    ) -> Result<Point, StudyError> {
        let repeats = self.request.repeats;
        let mut seconds = Vec::with_capacity(repeats);
        let mut errors = vec![0.0; reference.retroreflected.len()];
        let (mut estimated_l1, mut worst_estimated_l1) = (0.0, 0.0);
        let mut rays_per_bin = f64::INFINITY;
        for repeat in 0..repeats {
            let plan = self.plan(sampler, rays, repeat)?;
            let start = Instant::now();
            let prepared = Prepared::new(cell.clone());
            let table = Bake::new(&prepared, &plan)?
                .by(tracer)
                .table(Watch::none())?;
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
        Ok(Point {
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

/// The table of a cell, which is dissected anew: seconds count that too.
fn bake(cell: &Cell, plan: &Plan) -> Result<Table, RunError> {
    trace(&Prepared::new(cell.clone()), plan, Watch::none())
}

/// Name of a tracer in reports.
pub(crate) fn name(tracer: Tracer) -> &'static str {
    match tracer {
        Tracer::Fastest => "program",
        Tracer::OneByOne => "one by one",
    }
}

/// Directions that run as programs.
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
