//! Rays under way: runs over all threads, steps between two saves, rounds towards a tolerance. Integer sums, so that
//! neither threads nor ranks show in them.

use crate::plan::plan::{Method, Plan, RAYS_PER_RANDOMISATION, Shard};
use crate::rays::kernel::Kernel;
use crate::rays::lanes;
use crate::rays::path::Rules;
use crate::rays::sheet::Sheet;
use crate::rays::tally::{Bins, Sums, Tally};
use crate::run::provenance::provenance;
use crate::run::ranks::Ranks;
use crate::run::run::{RunError, Tracer};
use crate::run::saves::Saves;
use crate::samples::sequence::Stream;
use meshes::Cell;
use ndarray::{Array4, Array5};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;
use tables::deviation::{Deviations, Entry, Grid, added, counted};
use tables::{Fate, Shards, Table};

/// Rays per randomisation in the first round of a bake to a tolerance; each round doubles them.
const FIRST_ROUND: u64 = 1 << 12;

/// The same of the first step of a bake that is saved, where samples are sorted by piece.
const LONG_STEP: u64 = 1 << 18;

/// Programs in memory at a time, about 3 kB each: the directions of a sheet of many kinds are traced in turn.
const PROGRAMS: usize = 1 << 14;

/// Memory for exit directions at most, bytes: half of what a table may take.
const MOST_EXITS: u64 = 1 << 30;

/// The only share of a bake that is not split.
const WHOLE: Shard = Shard { number: 1, of: 1 };

/// A piece of work: samples of one randomisation of one direction.
struct Run<'a> {
    bundle: &'a Bundle,
    kernel: &'a Kernel,
    randomisation: usize,
    samples: Range<u64>,
}

impl Run<'_> {
    fn rays(&self) -> u64 {
        self.samples.end - self.samples.start
    }
}

/// Everything about one direction but its kernel.
pub(crate) struct Bundle {
    incidence_deg: f64,
    azimuth_deg: f64,
    streams: Vec<Stream>,
    /// Rays launched are those of all ranks; counts and fates are their sums in rank 0 after [`gather`], and
    /// until then what each traced since.
    sums: Mutex<Sums>,
}

impl Bundle {
    /// One for each direction of a plan, incidence slow, azimuth fast.
    pub(crate) fn all(plan: &Plan) -> Vec<Bundle> {
        let bins = Bins::new(plan.axes.bins, plan.axes.range);
        plan.axes
            .directions()
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

    /// Nothing can panic while the lock is held, so a poisoned lock still guards whole sums.
    fn sums(&self) -> MutexGuard<'_, Sums> {
        self.sums.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A bake under way in one process.
pub(crate) struct Work<'a> {
    pub cell: &'a Cell,
    pub plan: &'a Plan,
    pub tracer: Tracer,
    pub sheet: Sheet,
    pub rules: Rules,
    pub bins: Bins,
    /// How exit directions are recorded, where they are.
    pub exits: Option<Grid>,
    pub bundles: Vec<Bundle>,
    pub progress: &'a (dyn Fn(u64) + Sync),
    pub pool: rayon::ThreadPool,
}

impl Work<'_> {
    /// Traces the runs of rank `number` of `count`. What other ranks trace is counted as launched.
    fn trace(&self, runs: &[Run], number: usize, count: usize) {
        let mine = |(i, run)| (i % count == number).then_some(run);
        let own: Vec<&Run> = runs.iter().enumerate().filter_map(mine).collect();
        own.par_iter().for_each_init(
            || Tally::new(&self.bins),
            |tally, run| {
                tally.clear();
                let stream = &run.bundle.streams[run.randomisation];
                run.kernel.trace(stream, run.samples.clone(), tally);
                let exits = counted(&mut tally.exits);
                let mut sums = run.bundle.sums();
                sums.add(run.randomisation, tally);
                sums.add_exits(&exits);
                drop(sums);
                (self.progress)(run.rays());
            },
        );
        let others = runs.iter().enumerate().filter(|(i, _)| i % count != number);
        for (_, run) in others {
            run.bundle.sums().launched[run.randomisation] += run.rays();
            (self.progress)(run.rays());
        }
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
        let kernel = kernel.recording(self.exits);
        match self.tracer {
            Tracer::Fastest => kernel,
            Tracer::OneByOne => kernel.one_by_one(),
        }
    }

    /// The table of the sums so far.
    pub fn table(&self) -> Table {
        let axes = self.plan.axes.clone();
        let ((ni, na), nb, nr) = (axes.shape(), axes.bins, self.plan.randomisations);
        let mut counts = Array5::zeros((ni, na, nr, nb, nb));
        let mut fates = Array4::zeros((ni, na, nr, Fate::ALL.len()));
        let by_direction = counts.exact_chunks_mut((1, 1, nr, nb, nb)).into_iter();
        let fates_by_direction = fates
            .exact_chunks_mut((1, 1, nr, Fate::ALL.len()))
            .into_iter();
        for ((bundle, mut counts), mut fates) in self
            .bundles
            .iter()
            .zip(by_direction)
            .zip(fates_by_direction)
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
        let sampler = Some(self.plan.sampler);
        let provenance = provenance(self.cell, self.plan, Method::Rays, sampler);
        let entries = |bundle: &Bundle| bundle.sums().deviations.clone();
        Table {
            deviations: self.exits.map(|grid| Deviations {
                grid,
                entries: self.bundles.iter().map(entries).collect(),
            }),
            ..Table::from_counts(axes, counts, fates, provenance)
        }
    }

    /// Whether the exit directions so far fit their memory.
    fn fits(&self) -> Result<(), RunError> {
        let entries = |bundle: &Bundle| bundle.sums().deviations.len() as u64;
        let bytes = self.bundles.iter().map(entries).sum::<u64>() * size_of::<Entry>() as u64;
        match bytes <= MOST_EXITS {
            true => Ok(()),
            false => Err(RunError::Exits {
                directions: self.bundles.len(),
            }),
        }
    }
}

/// The steps of a bake, which all ranks make together.
pub(crate) struct Rounds<'a, 's> {
    pub work: Work<'a>,
    pub ranks: &'a dyn Ranks,
    /// All ranks save or none; rank 0 alone writes.
    pub saves: Option<Saves<'s>>,
}

impl Rounds<'_, '_> {
    /// Begins with what an interrupted bake had done, if rank 0 has any.
    pub fn go_on(&mut self) -> Result<(), RunError> {
        if let Some(saved) = self.saves.as_mut().and_then(|saves| saves.start.take()) {
            let fresh = self.work.table();
            let shape = |table: &Table| {
                let grid = table.deviations.as_ref().map(|found| found.grid);
                (table.counts.as_ref().map(|counts| counts.dim()), grid)
            };
            let same = saved.provenance.is_of_the_bake(&fresh.provenance)
                && saved.axes == fresh.axes
                && shape(&saved) == shape(&fresh);
            if !same {
                return Err(RunError::Saved);
            }
            (self.work.progress)(saved.rays.sum());
            for (bundle, sums) in self.work.bundles.iter().zip(Sums::of_table(&saved)) {
                *bundle.sums() = sums;
            }
        }
        for bundle in &self.work.bundles {
            self.ranks.follow(&mut bundle.sums().launched);
        }
        Ok(())
    }

    /// Traces `rays` of every direction.
    pub fn all(&mut self, rays: u64) -> Result<(), RunError> {
        let plan = self.work.plan;
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
        if self.ranks.leads() && self.work.bundles.iter().any(beyond) {
            return Err(RunError::Saved);
        }
        let every: Vec<usize> = (0..self.work.bundles.len()).collect();
        self.run(&every, &share)
    }

    /// Doubles the rays of each direction until its estimated error is below `tolerance`.
    pub fn until(&mut self, tolerance: f64) -> Result<(), RunError> {
        let mut open: Vec<usize> = (0..self.work.bundles.len()).collect();
        let mut samples = FIRST_ROUND;
        while !open.is_empty() {
            // Rank 0 alone has the sums; the others are ended with it.
            if samples > RAYS_PER_RANDOMISATION && self.ranks.leads() {
                let worst = &self.work.bundles[open[0]];
                let sums = worst.sums();
                return Err(RunError::Tolerance {
                    incidence_deg: worst.incidence_deg,
                    azimuth_deg: worst.azimuth_deg,
                    reached: sums.l1_error(),
                    rays: sums.rays(),
                });
            }
            self.run(&open, &|_| 0..samples)?;
            // A direction of a bake that goes on may be past this round, which then did not close it.
            let Work { bundles, pool, .. } = &self.work;
            let stays = |&direction: &usize| {
                let sums = bundles[direction].sums();
                u64::from(sums.launched[0] > samples || sums.l1_error() >= tolerance)
            };
            let mut keep = if self.ranks.leads() {
                pool.install(|| open.par_iter().map(stays).collect())
            } else {
                vec![0; open.len()]
            };
            self.ranks.follow(&mut keep);
            let mut keep = keep.into_iter();
            open.retain(|_| keep.next() == Some(1));
            samples *= 2;
        }
        Ok(())
    }

    /// Traces the samples `share(randomisation)` of every randomisation of the directions named, less those that are
    /// done: the sums of a randomisation always hold the first samples of its share.
    ///
    /// Where the bake is saved, all whose kernels fit in memory advance together, in steps short enough to be saved in
    /// time. Through a large scene rays are the faster the more of them go side by side: there whole runs are traced, some at
    /// a time, one direction after the other.
    fn run(
        &mut self,
        directions: &[usize],
        share: &dyn Fn(usize) -> Range<u64>,
    ) -> Result<(), RunError> {
        let Rounds { work, ranks, saves } = self;
        // Sorting by piece wants many samples.
        let first = if lanes::sorts(&work.sheet.launch) {
            LONG_STEP
        } else {
            FIRST_ROUND
        };
        let (number, count) = (ranks.number(), ranks.count());
        let large = work.sheet.scenes.iter().any(|scene| scene.is_large());
        let mut step = match saves {
            Some(_) if !large => first,
            _ => u64::MAX,
        };
        // One for each thread of all ranks, as rank 0 has them.
        let mut threads = [work.pool.current_num_threads() as u64];
        ranks.follow(&mut threads);
        let mut most = if large {
            threads[0] as usize * count
        } else {
            usize::MAX
        };
        for some in directions.chunks((PROGRAMS / work.sheet.scenes.len()).max(1)) {
            let kernel = |&direction: &usize| (&work.bundles[direction], work.kernel(direction));
            let kernels: Vec<(&Bundle, Kernel)> =
                work.pool.install(|| some.par_iter().map(kernel).collect());
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
                runs.truncate(most);
                let begun = Instant::now();
                work.pool.install(|| work.trace(&runs, number, count));
                work.fits()?;
                let Some(saves) = saves else { continue };
                let quick = begun.elapsed() < saves.every / 8;
                let mut told = [u64::from(quick), u64::from(saves.are_due())];
                ranks.follow(&mut told);
                if told[0] == 1 {
                    step = step.saturating_mul(2);
                    most = most.saturating_mul(2);
                }
                if told[1] == 1 {
                    saves.save(|| {
                        gather(&work.bundles, directions, *ranks);
                        ranks.leads().then(|| work.table())
                    });
                }
            }
        }
        gather(&work.bundles, directions, *ranks);
        work.fits()
    }
}

/// Adds up in rank 0 what the ranks have traced of the directions named.
fn gather(bundles: &[Bundle], directions: &[usize], ranks: &dyn Ranks) {
    for &direction in directions {
        let mut sums = bundles[direction].sums();
        ranks.gather(&mut sums.counts);
        ranks.gather(sums.fates.as_flattened_mut());
        gather_exits(&mut sums.deviations, ranks);
    }
}

/// Adds up in rank 0 what the ranks have traced, which are lists of different lengths; elsewhere they are empty afterwards.
fn gather_exits(entries: &mut Vec<Entry>, ranks: &dyn Ranks) {
    if ranks.count() == 1 {
        return;
    }
    let mut lengths = vec![0; ranks.count()];
    lengths[ranks.number()] = entries.len() as u64;
    ranks.gather(&mut lengths);
    ranks.follow(&mut lengths);
    let before: u64 = lengths[..ranks.number()].iter().sum();
    let mut all = vec![0; 2 * lengths.iter().sum::<u64>() as usize];
    let own = all[2 * before as usize..].chunks_exact_mut(2);
    for (pair, entry) in own.zip(entries.drain(..)) {
        pair.copy_from_slice(&[entry.place, entry.rays]);
    }
    ranks.gather(&mut all);
    if ranks.leads() {
        let mut rest = &all[..];
        for length in lengths {
            let (list, more) = rest.split_at(2 * length as usize);
            let entry = |pair: &[u64]| Entry {
                place: pair[0],
                rays: pair[1],
            };
            let list: Vec<Entry> = list.chunks_exact(2).map(entry).collect();
            *entries = added(entries, &list);
            rest = more;
        }
    }
}

/// Rays of randomisation number `which` when `rays` are shared by `among`.
fn share(rays: u64, among: usize, which: usize) -> u64 {
    let among = among as u64;
    rays / among + u64::from((which as u64) < rays % among)
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
