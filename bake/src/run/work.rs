//! Rays under way: runs over all threads, and their sums. These are of integers, so that neither
//! threads nor ranks show in them.

use crate::rays::{Bins, Index, Kernel, Sheet, Sums, Tally};
use crate::run::bake::Bake;
use crate::run::error::RunError;
use crate::run::watch::Watch;
use crate::samples::Stream;
use ndarray::{Array4, Array5};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};
use tables::cli::pool;
use tables::deviation::{Deviations, Entry, Grid, counted};
use tables::options::Method;
use tables::{Fate, Table};

/// Memory for exit directions at most, bytes: half of what a table may take.
const MOST_EXITS: u64 = 1 << 30;

/// A piece of work: samples of one randomisation of one direction.
pub(crate) struct Run<'a> {
    /// Where it counts.
    pub direction: &'a DirectionSums,
    /// What traces it.
    pub kernel: &'a Kernel,
    /// Number of the randomisation.
    pub randomisation: usize,
    /// Its samples.
    pub samples: Range<u64>,
}

impl Run<'_> {
    /// How many.
    pub(crate) fn rays(&self) -> u64 {
        self.samples.end - self.samples.start
    }
}

/// Everything about one direction but its kernel.
pub(crate) struct DirectionSums {
    /// Degrees.
    pub incidence_deg: f64,
    /// Degrees; NaN where every ray has its own.
    pub azimuth_deg: f64,
    /// Samples of each randomisation.
    pub streams: Vec<Stream>,
    /// Rays launched are those of all ranks; counts and fates are their sums in rank 0 after they
    /// were gathered, and until then what each traced since.
    sums: Mutex<Sums>,
}

impl DirectionSums {
    /// One for each direction of a bake, incidence slow, azimuth fast.
    fn all(bake: &Bake, bins: &Bins) -> Vec<DirectionSums> {
        let plan = bake.plan;
        bake.axes
            .directions()
            .map(|(incidence_deg, azimuth_deg)| DirectionSums {
                incidence_deg,
                azimuth_deg,
                streams: (0..plan.randomisations as u64)
                    .map(|r| Stream::new(plan.sampler, plan.seed, incidence_deg, azimuth_deg, r))
                    .collect(),
                sums: Mutex::new(Sums::new(bins, plan.randomisations)),
            })
            .collect()
    }

    /// Nothing can panic while the lock is held, so a poisoned lock still guards whole sums.
    pub(crate) fn sums(&self) -> MutexGuard<'_, Sums> {
        self.sums.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A bake under way in one process.
pub(crate) struct Work<'a> {
    /// What is baked.
    pub bake: &'a Bake<'a>,
    /// The cell as rays see it.
    pub sheet: Sheet,
    /// Bins of shifts.
    pub bins: Bins,
    /// How exit directions are recorded, where they are.
    pub exits: Option<Grid>,
    /// What is counted, incidence slow, azimuth fast.
    pub directions: Vec<DirectionSums>,
    /// Who is told.
    pub watch: Watch<'a>,
    /// Threads.
    pub pool: rayon::ThreadPool,
}

impl<'a> Work<'a> {
    /// Gets everything ready.
    ///
    /// # Errors
    /// [`RunError::Threads`].
    pub(crate) fn new(bake: &'a Bake<'a>, watch: Watch<'a>) -> Result<Self, RunError> {
        let bins = Bins::new(bake.axes.bins, bake.axes.range);
        Ok(Work {
            bake,
            sheet: Sheet::new(bake.prepared, Index::Auto),
            bins,
            exits: bake.plan.deviations(bake.prepared),
            directions: DirectionSums::all(bake, &bins),
            watch,
            pool: pool(bake.plan.threads)?,
        })
    }

    /// Traces the runs of rank `number` of `count`. What other ranks trace is counted as launched.
    pub(crate) fn trace(&self, runs: &[Run], number: usize, count: usize) {
        let mine = |(i, run)| (i % count == number).then_some(run);
        let own: Vec<&Run> = runs.iter().enumerate().filter_map(mine).collect();
        own.par_iter().for_each_init(
            || Tally::new(&self.bins),
            |tally, run| {
                if self.watch.is_stopped() {
                    return;
                }
                tally.clear();
                let stream = &run.direction.streams[run.randomisation];
                run.kernel.trace(stream, run.samples.clone(), tally);
                let exits = counted(&mut tally.exits);
                let mut sums = run.direction.sums();
                sums.add(run.randomisation, tally);
                sums.add_exits(&exits);
                drop(sums);
                self.watch.tell(run.rays());
            },
        );
        let others = runs.iter().enumerate().filter(|(i, _)| i % count != number);
        for (_, run) in others {
            run.direction.sums().launched[run.randomisation] += run.rays();
            self.watch.tell(run.rays());
        }
    }

    /// What traces direction number `direction`.
    pub(crate) fn kernel(&self, direction: usize) -> Kernel {
        let DirectionSums {
            incidence_deg,
            azimuth_deg,
            ..
        } = self.directions[direction];
        let kernel = Kernel::over(
            &self.sheet,
            &self.bake.rules,
            &self.bins,
            incidence_deg,
            azimuth_deg,
        );
        kernel.recording(self.exits).by(self.bake.tracer)
    }

    /// The table of the sums so far.
    pub(crate) fn table(&self) -> Table {
        let axes = self.bake.axes.clone();
        let ((ni, na), nb, nr) = (axes.shape(), axes.bins, self.bake.plan.randomisations);
        let mut counts = Array5::zeros((ni, na, nr, nb, nb));
        let mut fates = Array4::zeros((ni, na, nr, Fate::ALL.len()));
        let by_direction = counts.exact_chunks_mut((1, 1, nr, nb, nb)).into_iter();
        let fates_by_direction = fates
            .exact_chunks_mut((1, 1, nr, Fate::ALL.len()))
            .into_iter();
        for ((direction, mut counts), mut fates) in self
            .directions
            .iter()
            .zip(by_direction)
            .zip(fates_by_direction)
        {
            let sums = direction.sums();
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
        let sampler = Some(self.bake.plan.sampler);
        let provenance = self.bake.provenance(Method::Rays, sampler);
        let entries = |direction: &DirectionSums| direction.sums().deviations.clone();
        Table {
            deviations: self.exits.map(|grid| Deviations {
                grid,
                entries: self.directions.iter().map(entries).collect(),
            }),
            ..Table::from_counts(axes, counts, fates, provenance)
        }
    }

    /// Whether the exit directions so far fit their memory.
    ///
    /// # Errors
    /// [`RunError::Exits`].
    pub(crate) fn fits(&self) -> Result<(), RunError> {
        let entries = |direction: &DirectionSums| direction.sums().deviations.len() as u64;
        let bytes = self.directions.iter().map(entries).sum::<u64>() * size_of::<Entry>() as u64;
        match bytes <= MOST_EXITS {
            true => Ok(()),
            false => Err(RunError::Exits {
                directions: self.directions.len(),
            }),
        }
    }
}
