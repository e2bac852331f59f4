//! Steps of a bake by rays, which all ranks make together.
//!
//! They are steps between two saves, and rounds towards a tolerance.

use crate::error::Error;
use crate::plan::{RAYS_PER_RANDOMISATION, Shard};
use crate::rays::programs::lanes;
use crate::rays::{Kernel, Sums};
use crate::run::ranks::Ranks;
use crate::run::saves::Saves;
use crate::run::work::{DirectionSums, Run, Work};
use rayon::prelude::*;
use std::ops::Range;
use std::time::Instant;
use tables::deviation::{Entry, added};
use tables::{Shards, Table};

/// Number of rays per randomisation in the first round of a bake to a tolerance.
///
/// Each round doubles it.
const FIRST_ROUND: u64 = 1 << 12;

/// Number of rays per randomisation in the first step of a saved bake with samples sorted by piece.
const LONG_STEP: u64 = 1 << 18;

/// Largest number of programs in memory at a time, each of about 3 kB.
///
/// The directions of a sheet of many kinds of bodies are therefore traced in turn.
const PROGRAMS: usize = 1 << 14;

/// Share of a bake that is not split: the first of one.
const WHOLE_BAKE: Shard = Shard { number: 1, of: 1 };

/// Adds up in rank 0 the counts that all ranks have traced of the directions `named`.
fn gather(all: &[DirectionSums], named: &[usize], ranks: &dyn Ranks) {
    for &direction in named {
        let mut sums = all[direction].sums();
        ranks.gather(&mut sums.counts);
        ranks.gather(sums.fates.as_flattened_mut());
        gather_exits(&mut sums.deviations, ranks);
    }
}

/// Adds up in rank 0 the exit directions of all ranks, which are lists of different lengths.
///
/// In the other ranks the lists are empty afterwards.
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

/// Returns the number of rays of randomisation `which` if `rays` are shared by `among` of them.
fn share(rays: u64, among: usize, which: usize) -> u64 {
    let among = among as u64;
    rays / among + u64::from((which as u64) < rays % among)
}

/// Amount of work that is traced between two looks at the clock.
struct Pace {
    /// Number of rays of each randomisation of a direction.
    step: u64,
    /// Largest number of runs.
    most: usize,
    /// Number of threads of all ranks.
    threads: usize,
}

impl Pace {
    /// Returns the amount of work of the first step of a bake that `is_saved` or not.
    fn first(work: &Work, ranks: &dyn Ranks, is_saved: bool) -> Self {
        // Sorting by piece needs many samples.
        let first = if lanes::sorts(&work.sheet.launch) {
            LONG_STEP
        } else {
            FIRST_ROUND
        };
        // So does sorting by facet: there whole runs are traced.
        let mut scenes = work.sheet.scenes.iter();
        let large = scenes.any(|scene| scene.is_large() || scene.for_groups().is_some());
        // One run for each thread of all ranks; every rank takes the number of threads of rank 0.
        let mut threads = [work.pool.current_num_threads() as u64];
        ranks.follow(&mut threads);
        let threads = threads[0] as usize * ranks.count();
        Pace {
            step: if is_saved && !large { first } else { u64::MAX },
            most: if large { threads } else { usize::MAX },
            threads,
        }
    }

    fn double(&mut self) {
        self.step = self.step.saturating_mul(2);
        self.most = self.most.saturating_mul(2);
    }
}

/// Returns the runs that come next, with up to `pace.step` samples of each randomisation.
///
/// They are cut to the length that is best traced in one piece. Where rays are sorted, a piece
/// takes the samples of several randomisations.
fn next<'a>(
    kernels: &'a [(&DirectionSums, Kernel)],
    share: &dyn Fn(usize) -> Range<u64>,
    pace: &Pace,
) -> Vec<Run<'a>> {
    let mut runs = Vec::new();
    // If there are more threads than directions, each direction is cut for several of them.
    let cuts = pace.threads.div_ceil(kernels.len().max(1));
    for (direction, kernel) in kernels {
        let launched = &direction.sums().launched;
        let rest = |(randomisation, done): (usize, &u64)| {
            let Range { start, end } = share(randomisation);
            (end - start).saturating_sub(*done).min(pace.step)
        };
        let rest: u64 = launched.iter().enumerate().map(rest).sum();
        let length = kernel.run(rest.div_ceil(cuts as u64));
        let run = |samples| Run {
            direction,
            kernel,
            samples,
        };
        let (mut open, mut room) = (Vec::new(), length);
        for (randomisation, done) in launched.iter().enumerate() {
            let Range { start, end } = share(randomisation);
            let mut start = start + done;
            let end = end.min(start.saturating_add(pace.step));
            while start < end {
                let cut = end.min(start + room);
                open.push((randomisation, start..cut));
                room -= cut - start;
                start = cut;
                if room == 0 || start == end && !kernel.mixes() {
                    runs.push(run(std::mem::take(&mut open)));
                    room = length;
                }
            }
        }
        if !open.is_empty() {
            runs.push(run(open));
        }
    }
    runs
}

/// Steps of a bake, which all ranks make together.
pub(crate) struct Rounds<'a, 's> {
    /// Work done so far.
    pub work: Work<'a>,
    /// Processes that share the work.
    pub ranks: &'a dyn Ranks,
    /// Saves of the bake. If one rank has them, all ranks have them; rank 0 alone writes.
    pub saves: Option<Saves<'s>>,
}

/// Makes the error of a saved state that belongs to another bake.
fn other_bake() -> Error {
    Error::Usage(
        "the bake that was saved is another one (its mesh, directions or options differ); repeat \
        the options that it began with, or leave out --resume"
            .into(),
    )
}

impl Rounds<'_, '_> {
    /// Goes on from the saved state of an interrupted bake, if rank 0 has one.
    ///
    /// # Errors
    /// Returns an [`Error`] if the saved state is that of another bake.
    pub(crate) fn go_on(&mut self) -> Result<(), Error> {
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
                return Err(other_bake());
            }
            self.work.progress.tell(saved.rays.sum());
            for (direction, sums) in self.work.directions.iter().zip(Sums::of_table(&saved)) {
                *direction.sums() = sums;
            }
        }
        for direction in &self.work.directions {
            self.ranks.follow(&mut direction.sums().launched);
        }
        Ok(())
    }

    /// Traces `rays` rays of every direction.
    ///
    /// # Errors
    /// Returns an [`Error`] if the saved state has more rays than that, if the caller stopped the
    /// bake, or if the exit directions take too much memory.
    pub(crate) fn all(&mut self, rays: u64) -> Result<(), Error> {
        let plan = self.work.bake.plan;
        let share = |randomisation: usize| {
            let samples = share(rays, plan.randomisations, randomisation);
            let Shard { number, of } = plan.shard.unwrap_or(WHOLE_BAKE);
            Shards::samples(number, of, samples)
        };
        let beyond = |direction: &DirectionSums| {
            let sums = direction.sums();
            let mut launched = sums.launched.iter().enumerate();
            launched.any(|(r, &done)| done > share(r).end - share(r).start)
        };
        if self.ranks.leads() && self.work.directions.iter().any(beyond) {
            return Err(other_bake());
        }
        let every: Vec<usize> = (0..self.work.directions.len()).collect();
        self.run(&every, &share)
    }

    /// Doubles the rays of each direction until its estimated error is below `tolerance`.
    ///
    /// # Errors
    /// Returns an [`Error`] if a direction has an error above `tolerance` after the most rays
    /// possible, if the caller stopped the bake, or if the exit directions take too much memory.
    pub(crate) fn until(&mut self, tolerance: f64) -> Result<(), Error> {
        let mut open: Vec<usize> = (0..self.work.directions.len()).collect();
        let mut samples = FIRST_ROUND;
        while !open.is_empty() {
            // Only rank 0 has the sums. The other ranks are ended when rank 0 fails.
            if samples > RAYS_PER_RANDOMISATION && self.ranks.leads() {
                let worst = &self.work.directions[open[0]];
                let sums = worst.sums();
                return Err(Error::Failed(format!(
                    "the estimated L1 error at incidence {} deg, azimuth {} deg is still {:.2e} \
                    after {} rays; give a --tolerance above that, or fewer --bins",
                    worst.incidence_deg,
                    worst.azimuth_deg,
                    sums.l1_error(),
                    sums.rays()
                )));
            }
            self.run(&open, &|_| 0..samples)?;
            // In a bake that goes on, a direction may have more rays than this round gives. Then it
            // was not within the tolerance after this round, and it stays open.
            let Work {
                directions, pool, ..
            } = &self.work;
            let stays = |&direction: &usize| {
                let sums = directions[direction].sums();
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

    /// Traces the samples `share(randomisation)` of every randomisation of the directions given.
    ///
    /// Samples that are done already are left out: the sums of a randomisation always hold the
    /// first samples of its share.
    ///
    /// If the bake is saved, all directions whose kernels fit in memory advance together, in steps
    /// that are short enough for the next save. Down a hierarchy, rays are faster if more of them
    /// go side by side. There whole runs are traced, some at a time, one direction after the other.
    fn run(
        &mut self,
        directions: &[usize],
        share: &dyn Fn(usize) -> Range<u64>,
    ) -> Result<(), Error> {
        let Rounds { work, ranks, saves } = self;
        let mut pace = Pace::first(work, *ranks, saves.is_some());
        for some in directions.chunks((PROGRAMS / work.sheet.scenes.len()).max(1)) {
            let kernel = |&direction: &usize| (&work.directions[direction], work.kernel(direction));
            let kernels: Vec<(&DirectionSums, Kernel)> =
                work.pool.install(|| some.par_iter().map(kernel).collect());
            loop {
                let mut runs = next(&kernels, share, &pace);
                if runs.is_empty() {
                    break;
                }
                runs.truncate(pace.most);
                let begun = Instant::now();
                let (number, count) = (ranks.number(), ranks.count());
                work.pool.install(|| work.trace(&runs, number, count));
                if work.progress.is_stopped() {
                    return Err(Error::Stopped);
                }
                work.fits()?;
                let Some(saves) = saves else { continue };
                let quick = begun.elapsed() < saves.every / 8;
                let mut told = [u64::from(quick), u64::from(saves.are_due())];
                ranks.follow(&mut told);
                if told[0] == 1 {
                    pace.double();
                }
                if told[1] == 1 {
                    saves.save(|| {
                        gather(&work.directions, directions, *ranks);
                        ranks.leads().then(|| work.table())
                    });
                }
            }
        }
        gather(&work.directions, directions, *ranks);
        work.fits()
    }
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
