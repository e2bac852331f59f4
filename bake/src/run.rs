//! The bake itself: runs of rays over all threads, integer sums, the table. Prints nothing.

use crate::exact::{self, ExactCell, ExactError};
use crate::kernel::Kernel;
use crate::lanes;
use crate::path::Rules;
use crate::plan::{Effort, Method, Plan, RAYS_PER_RANDOMISATION, Shard};
use crate::provenance::provenance;
use crate::saves::Saves;
use crate::scene::Index;
use crate::sequence::Stream;
use crate::sheet::Sheet;
use crate::tally::{Bins, Sums, Tally};
use meshes::Cell;
use ndarray::{Array2, Array4, Array5};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;
use tables::{Fate, Provenance, Shards, Table};
use thiserror::Error;

/// Rays per randomisation in the first round of a bake to a tolerance; each round doubles them.
const FIRST_ROUND: u64 = 1 << 12;

/// The same of the first step of a bake that is saved, where samples are sorted by piece.
const LONG_STEP: u64 = 1 << 18;

/// Programs in memory at a time, about 3 kB each: the directions of a sheet of many kinds are traced in turn.
const PROGRAMS: usize = 1 << 14;

/// The only share of a bake that is not split.
const WHOLE: Shard = Shard { number: 1, of: 1 };

/// How the rays of a direction are traced; tests hold both to the same fates, ray for ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tracer {
    /// As a program, many rays at once, where the cell and the direction allow it; else one by one.
    Fastest,
    /// One by one, against all facets: what every cell allows.
    OneByOne,
}

/// Why a bake failed.
#[derive(Debug, Error)]
pub enum RunError {
    /// The threads could not be started.
    #[error("cannot start {threads} threads ({source}); give fewer with --threads")]
    Threads {
        /// Threads asked for.
        threads: usize,
        /// What the system said.
        source: rayon::ThreadPoolBuildError,
    },
    /// The cell or the directions are not for the exact method.
    #[error("--method exact: {0}")]
    Exact(#[from] ExactError),
    /// Something else was saved.
    #[error(
        "the bake that was saved is another one (its mesh, directions or options differ); repeat the options that it began with, or leave out --resume"
    )]
    Saved,
    /// A share of what has no samples.
    #[error(
        "--shard: the exact method takes this cell and traces no rays to share out; leave out --shard, or give --method \
         rays"
    )]
    ShardOfExact,
    /// The tolerance is out of reach.
    #[error(
        "the estimated L1 error at incidence {incidence_deg} deg, azimuth {azimuth_deg} deg is still {reached:.2e} \
         after {rays} rays; give a --tolerance above that, or fewer --bins"
    )]
    Tolerance {
        /// Incidence of the worst direction, degrees.
        incidence_deg: f64,
        /// Its azimuth, degrees.
        azimuth_deg: f64,
        /// Estimated error reached.
        reached: f64,
        /// Rays spent on that direction.
        rays: u64,
    },
}

/// A piece of work: samples of one randomisation of one direction.
struct Run<'a> {
    bundle: &'a Bundle,
    kernel: &'a Kernel,
    randomisation: usize,
    samples: Range<u64>,
}

/// Everything about one direction but its kernel.
struct Bundle {
    incidence_deg: f64,
    azimuth_deg: f64,
    streams: Vec<Stream>,
    sums: Mutex<Sums>,
}

/// Bakes `cell` as planned, by the method that the plan names; `auto` is the exact method where [`exact::prepare`]
/// takes the cell, else rays.
///
/// # Errors
/// As [`rays`]; [`RunError::Exact`] where the plan insists on the exact method and it does not take the cell.
pub fn bake(cell: &Cell, plan: &Plan, progress: &(dyn Fn(u64) + Sync)) -> Result<Table, RunError> {
    bake_from(cell, plan, progress, None)
}

/// As [`bake`], from where an interrupted bake was saved, and saved in its turn.
///
/// # Errors
/// As [`bake`]; [`RunError::Saved`] where what was saved is of another bake.
pub fn bake_from(
    cell: &Cell,
    plan: &Plan,
    progress: &(dyn Fn(u64) + Sync),
    saves: Option<Saves<'_>>,
) -> Result<Table, RunError> {
    match (plan.method, exact::prepare(cell, &plan.axes)) {
        (Method::Rays, _) | (Method::Auto, Err(_)) => {
            traced(Tracer::Fastest, cell, plan, progress, saves)
        }
        (_, Ok(_)) if plan.shard.is_some() => Err(RunError::ShardOfExact),
        (_, Ok(prepared)) => beams(cell, &prepared, plan, progress),
        (Method::Exact, Err(refusal)) => Err(refusal.into()),
    }
}

/// The exact bake. Whatever is asked of rays (number, tolerance, sampler, seed) has no part in the table.
fn beams(
    cell: &Cell,
    prepared: &ExactCell,
    plan: &Plan,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Table, RunError> {
    let rays_saved = match plan.effort {
        Effort::Rays(rays) => rays,
        Effort::Tolerance(_) => 0,
    };
    let baked = pool(plan)?.install(|| {
        exact::bake(prepared, &plan.axes, &plan.rules(cell), || {
            progress(rays_saved)
        })
    });
    Ok(Table {
        axes: plan.axes.clone(),
        histogram: baked.histogram,
        counts: None,
        standard_error: Array2::zeros(plan.axes.shape()),
        retroreflected: baked.retroreflected,
        fate: baked.fate,
        fate_counts: None,
        rays: Array2::zeros(plan.axes.shape()),
        exact: Some(baked.exact),
        provenance: Provenance {
            seed: 0,
            tolerance: 0.0,
            shards: None,
            ..provenance(cell, plan, "exact".into(), "none".into())
        },
    })
}

fn pool(plan: &Plan) -> Result<rayon::ThreadPool, RunError> {
    let threads = plan.threads.map_or(0, |threads| threads.get());
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|source| RunError::Threads { threads, source })
}

/// Traces rays through `cell` as planned. `progress` is told, from any thread, how many rays were done since the last
/// call. The table is the same, byte for byte, whatever the number of threads.
///
/// # Errors
/// [`RunError`]: no threads, or a tolerance out of reach.
pub fn rays(cell: &Cell, plan: &Plan, progress: &(dyn Fn(u64) + Sync)) -> Result<Table, RunError> {
    rays_by(Tracer::Fastest, cell, plan, progress)
}

/// [`rays`] by the tracer given.
///
/// # Errors
/// As [`rays`].
pub fn rays_by(
    tracer: Tracer,
    cell: &Cell,
    plan: &Plan,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Table, RunError> {
    traced(tracer, cell, plan, progress, None)
}

fn traced(
    tracer: Tracer,
    cell: &Cell,
    plan: &Plan,
    progress: &(dyn Fn(u64) + Sync),
    mut saves: Option<Saves<'_>>,
) -> Result<Table, RunError> {
    let bundles = bundles(plan);
    if let Some(saved) = saves.as_mut().and_then(|saves| saves.start.take()) {
        continued(&bundles, &saved, &table(cell, plan, &bundles))?;
        progress(saved.rays.sum());
    }
    let work = Work {
        cell,
        plan,
        tracer,
        sheet: Sheet::new(cell, Index::Auto),
        rules: plan.rules(cell),
        bins: Bins::new(plan.axes.bins, plan.axes.range),
        bundles,
        progress,
        pool: pool(plan)?,
    };
    match plan.effort {
        Effort::Rays(rays) => {
            let every: Vec<usize> = (0..work.bundles.len()).collect();
            let share = |randomisation: usize| {
                let samples = share(rays, plan.randomisations, randomisation);
                let Shard { number, of } = plan.shard.unwrap_or(WHOLE);
                Shards::samples(number, of, samples)
            };
            let beyond = |bundle: &Bundle| {
                let sums = bundle.sums();
                let mut launched = sums.launched.iter().enumerate();
                launched.any(|(r, &done)| done > share(r).end - share(r).start)
            };
            if work.bundles.iter().any(beyond) {
                return Err(RunError::Saved);
            }
            work.run(&every, &share, &mut saves);
        }
        Effort::Tolerance(tolerance) => work.until(tolerance, &mut saves)?,
    }
    Ok(table(cell, plan, &work.bundles))
}

/// Fills the sums of a bake that begins with those of one that was interrupted. `fresh` is the table of its start.
fn continued(bundles: &[Bundle], saved: &Table, fresh: &Table) -> Result<(), RunError> {
    let shape = |table: &Table| table.counts.as_ref().map(|counts| counts.dim());
    let same = saved.provenance == fresh.provenance
        && saved.axes == fresh.axes
        && shape(saved) == shape(fresh);
    if !same {
        return Err(RunError::Saved);
    }
    for (bundle, sums) in bundles.iter().zip(Sums::of_table(saved)) {
        *bundle.sums() = sums;
    }
    Ok(())
}

/// Rays of randomisation number `which` when `rays` are shared by `among`.
fn share(rays: u64, among: usize, which: usize) -> u64 {
    let among = among as u64;
    rays / among + u64::from((which as u64) < rays % among)
}

fn bundles(plan: &Plan) -> Vec<Bundle> {
    let bins = Bins::new(plan.axes.bins, plan.axes.range);
    let directions = plan
        .axes
        .incidence_deg
        .iter()
        .flat_map(|&i| plan.axes.azimuth_deg.iter().map(move |&a| (i, a)));
    directions
        .map(|(incidence_deg, azimuth_deg)| Bundle {
            incidence_deg,
            azimuth_deg,
            streams: (0..plan.randomisations as u64)
                .map(|r| Stream::new(plan.sampler, plan.seed, incidence_deg, azimuth_deg, r))
                .collect(),
            sums: Mutex::new(Sums::new(&bins, plan.randomisations)),
        })
        .collect()
}

impl Bundle {
    /// Nothing can panic while the lock is held, so a poisoned lock still guards whole sums.
    fn sums(&self) -> MutexGuard<'_, Sums> {
        self.sums.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A bake under way.
struct Work<'a> {
    cell: &'a Cell,
    plan: &'a Plan,
    tracer: Tracer,
    sheet: Sheet,
    rules: Rules,
    bins: Bins,
    bundles: Vec<Bundle>,
    progress: &'a (dyn Fn(u64) + Sync),
    pool: rayon::ThreadPool,
}

impl Work<'_> {
    /// Traces the samples `share(randomisation)` of every randomisation of the directions named, less those that are
    /// done: the sums of a randomisation always hold the first samples of its share.
    ///
    /// Where the bake is saved, all whose kernels fit in memory advance together, in steps short enough to be saved in
    /// time.
    fn run(
        &self,
        directions: &[usize],
        share: &dyn Fn(usize) -> Range<u64>,
        saves: &mut Option<Saves<'_>>,
    ) {
        // Sorting by piece wants many samples.
        let first = if lanes::sorts(&self.sheet.launch) {
            LONG_STEP
        } else {
            FIRST_ROUND
        };
        let mut step = saves.as_ref().map_or(u64::MAX, |_| first);
        for some in directions.chunks((PROGRAMS / self.sheet.scenes.len()).max(1)) {
            let kernel = |&direction: &usize| (&self.bundles[direction], self.kernel(direction));
            let kernels: Vec<(&Bundle, Kernel)> =
                self.pool.install(|| some.par_iter().map(kernel).collect());
            loop {
                let mut runs = Vec::new();
                for (bundle, kernel) in &kernels {
                    let launched = &bundle.sums().launched;
                    for (randomisation, done) in launched.iter().enumerate() {
                        let Range { start, end } = share(randomisation);
                        let start = start + done;
                        let end = end.min(start.saturating_add(step));
                        let length = kernel.run();
                        let cuts = (start..end).step_by(length as usize);
                        runs.extend(cuts.map(|from| Run {
                            bundle,
                            kernel,
                            randomisation,
                            samples: from..end.min(from + length),
                        }));
                    }
                }
                if runs.is_empty() {
                    break;
                }
                let begun = Instant::now();
                self.pool.install(|| self.trace(&runs));
                if let Some(saves) = saves {
                    if begun.elapsed() < saves.every / 8 {
                        step = step.saturating_mul(2);
                    }
                    saves.when_due(|| table(self.cell, self.plan, &self.bundles));
                }
            }
        }
    }

    fn trace(&self, runs: &[Run]) {
        runs.par_iter().for_each_init(
            || Tally::new(&self.bins),
            |tally, run| {
                tally.clear();
                let stream = &run.bundle.streams[run.randomisation];
                run.kernel.trace(stream, run.samples.clone(), tally);
                run.bundle.sums().add(run.randomisation, tally);
                (self.progress)(run.samples.end - run.samples.start);
            },
        );
    }

    fn kernel(&self, direction: usize) -> Kernel {
        let Bundle {
            incidence_deg,
            azimuth_deg,
            ..
        } = self.bundles[direction];
        let kernel = Kernel::over(
            &self.sheet,
            &self.rules,
            &self.bins,
            incidence_deg,
            azimuth_deg,
        );
        match self.tracer {
            Tracer::Fastest => kernel,
            Tracer::OneByOne => kernel.one_by_one(),
        }
    }

    /// Doubles the rays of each direction until its estimated error is below `tolerance`.
    fn until(&self, tolerance: f64, saves: &mut Option<Saves<'_>>) -> Result<(), RunError> {
        let mut open: Vec<usize> = (0..self.bundles.len()).collect();
        let mut samples = FIRST_ROUND;
        while !open.is_empty() {
            if samples > RAYS_PER_RANDOMISATION {
                let worst = open[0];
                let azimuths = self.plan.axes.azimuth_deg.len();
                let sums = self.bundles[worst].sums();
                return Err(RunError::Tolerance {
                    incidence_deg: self.plan.axes.incidence_deg[worst / azimuths],
                    azimuth_deg: self.plan.axes.azimuth_deg[worst % azimuths],
                    reached: sums.l1_error(),
                    rays: sums.rays(),
                });
            }
            self.run(&open, &|_| 0..samples, saves);
            // A direction of a bake that goes on may be past this round, which then did not close it.
            let stays = |direction: &usize| {
                let sums = self.bundles[*direction].sums();
                sums.launched[0] > samples || sums.l1_error() >= tolerance
            };
            let keep: Vec<bool> = self.pool.install(|| open.par_iter().map(stays).collect());
            open = open
                .into_iter()
                .zip(keep)
                .filter_map(|(d, keep)| keep.then_some(d))
                .collect();
            samples *= 2;
        }
        Ok(())
    }
}

fn table(cell: &Cell, plan: &Plan, bundles: &[Bundle]) -> Table {
    let axes = plan.axes.clone();
    let ((ni, na), nb, nr) = (axes.shape(), axes.bins, plan.randomisations);
    let mut counts = Array5::zeros((ni, na, nr, nb, nb));
    let mut fates = Array4::zeros((ni, na, nr, Fate::ALL.len()));
    let by_direction = counts.exact_chunks_mut((1, 1, nr, nb, nb)).into_iter();
    let fates_by_direction = fates
        .exact_chunks_mut((1, 1, nr, Fate::ALL.len()))
        .into_iter();
    for ((bundle, mut counts), mut fates) in
        bundles.iter().zip(by_direction).zip(fates_by_direction)
    {
        let sums = bundle.sums();
        let from = sums.counts.iter().copied();
        counts
            .iter_mut()
            .zip(from)
            .for_each(|(count, sum)| *count = sum);
        let from = sums.fates.iter().flatten().copied();
        fates
            .iter_mut()
            .zip(from)
            .for_each(|(count, sum)| *count = sum);
    }
    let provenance = provenance(cell, plan, "rays".into(), plan.sampler.name().into());
    Table::from_counts(axes, counts, fates, provenance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_add_up() {
        for rays in [1, 15, 16, 17, 4_194_304, (1 << 34) + 5] {
            let among = rays.min(16) as usize;
            let sum: u64 = (0..among).map(|which| share(rays, among, which)).sum();
            assert_eq!(sum, rays);
        }
    }
}
