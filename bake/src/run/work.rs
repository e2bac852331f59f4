//! Rays under way: runs over all threads, and their sums.
//!
//! The sums are integers, so the number of threads or ranks has no effect on them.

use crate::error::Error;
use crate::geometry::Stream;
use crate::rays::{Accumulator, Bins, Index, Kernel, SampleRange, Sheet, Sums};
use crate::run::bake::Bake;
use crate::run::bake::Progress;
use ndarray::{Array4, Array5};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};
use tables::Table;
use tables::cli::pool;
use tables::deviation::{Deviations, Entry, Grid};
use tables::options::Method;

/// Largest memory for exit directions, bytes: half of what a table may take.
const MOST_EXITS: u64 = 1 << 30;

/// Piece of work: samples of one direction.
pub(crate) struct Run<'a> {
    /// Sums that the run is added to.
    pub direction: &'a DirectionSums,
    /// Tracer of the run.
    pub kernel: &'a Kernel,
    /// Numbers of the randomisations, with the indices of their samples.
    pub samples: Vec<(usize, Range<u64>)>,
}

impl Run<'_> {
    /// Returns the number of rays.
    pub(crate) fn rays(&self) -> u64 {
        let samples = self.samples.iter();
        samples.map(|(_, part)| part.end - part.start).sum()
    }
}

/// Everything about one direction except its kernel.
pub(crate) struct DirectionSums {
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Azimuth, degrees; NaN where every ray has its own.
    pub azimuth_deg: f64,
    /// Streams of samples, one for each randomisation.
    pub streams: Vec<Stream>,
    /// Sums of the direction.
    ///
    /// The numbers of rays launched are those of all ranks. Counts and fates are those that this
    /// rank has traced since the last gathering. In rank 0 they include the sums of all ranks up to
    /// that gathering.
    sums: Mutex<Sums>,
}

impl DirectionSums {
    /// Makes the empty sums of all directions of a bake, incidence slow, azimuth fast.
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

    /// Locks the sums and returns them.
    ///
    /// Nothing can panic while the lock is held, so even a poisoned lock guards whole sums.
    pub(crate) fn sums(&self) -> MutexGuard<'_, Sums> {
        self.sums.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Bake under way in one process.
pub(crate) struct Work<'a> {
    /// Bake that the work belongs to.
    pub bake: &'a Bake<'a>,
    /// Cell as rays see it.
    pub sheet: Sheet,
    /// Bins of shifts.
    pub bins: Bins,
    /// Grid that exit directions are recorded on; `None` if they are not recorded.
    pub exits: Option<Grid>,
    /// Sums of all directions, incidence slow, azimuth fast.
    pub directions: Vec<DirectionSums>,
    /// Progress that the caller sees.
    pub progress: Progress<'a>,
    /// Threads that trace the runs.
    pub pool: rayon::ThreadPool,
}

impl<'a> Work<'a> {
    /// Prepares everything that the rays need.
    ///
    /// # Errors
    /// Returns an [`Error`] if the threads cannot be started.
    pub(crate) fn new(bake: &'a Bake<'a>, progress: Progress<'a>) -> Result<Self, Error> {
        let bins = Bins::new(bake.axes.bins, bake.axes.range);
        Ok(Work {
            bake,
            sheet: Sheet::new(bake.prepared, Index::Auto),
            bins,
            exits: bake.plan.deviations(bake.prepared),
            directions: DirectionSums::all(bake, &bins),
            progress,
            pool: pool(bake.plan.threads)?,
        })
    }

    /// Traces those of the runs that belong to rank `number` of `count`.
    ///
    /// The rays of the other runs are counted as launched.
    pub(crate) fn trace(&self, runs: &[Run], number: usize, count: usize) {
        let mine = |(i, run)| (i % count == number).then_some(run);
        let own: Vec<&Run> = runs.iter().enumerate().filter_map(mine).collect();
        own.par_iter()
            .for_each_init(Vec::new, |accumulators: &mut Vec<Accumulator>, run| {
                if self.progress.is_stopped() {
                    return;
                }
                let count = run.samples.len();
                if accumulators.len() < count {
                    accumulators.resize_with(count, || Accumulator::new(&self.bins));
                }
                let accumulators = &mut accumulators[..count];
                accumulators.iter_mut().for_each(Accumulator::clear);
                let part = |(randomisation, samples): &(usize, Range<u64>)| SampleRange {
                    stream: run.direction.streams[*randomisation],
                    samples: samples.clone(),
                };
                let parts: Vec<SampleRange> = run.samples.iter().map(part).collect();
                run.kernel.trace_parts(&parts, accumulators);
                for ((randomisation, _), accumulator) in run.samples.iter().zip(accumulators) {
                    let exits = accumulator.take_exits();
                    let mut sums = run.direction.sums();
                    sums.add(*randomisation, accumulator);
                    sums.add_exits(&exits);
                }
                self.progress.tell(run.rays());
            });
        let others = runs.iter().enumerate().filter(|(i, _)| i % count != number);
        for (_, run) in others {
            let launched = &mut run.direction.sums().launched;
            for (randomisation, samples) in &run.samples {
                launched[*randomisation] += samples.end - samples.start;
            }
            self.progress.tell(run.rays());
        }
    }

    /// Makes the tracer of direction number `direction`.
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

    /// Returns the table of the sums so far.
    pub(crate) fn table(&self) -> Table {
        let axes = self.bake.axes.clone();
        let ((ni, na), nb, nr) = (axes.shape(), axes.bins, self.bake.plan.randomisations);
        let mut counts = Array5::zeros((ni, na, nr, nb, nb));
        let nf = self.bake.rules.fates().len();
        let mut fates = Array4::zeros((ni, na, nr, nf));
        let by_direction = counts.exact_chunks_mut((1, 1, nr, nb, nb)).into_iter();
        let fates_by_direction = fates.exact_chunks_mut((1, 1, nr, nf)).into_iter();
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
            let from = sums.fates.iter().flat_map(|fates| &fates[..nf]).copied();
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

    /// Checks that the exit directions so far fit in their memory.
    ///
    /// # Errors
    /// Returns an [`Error`] if they take too much memory.
    pub(crate) fn fits(&self) -> Result<(), Error> {
        let entries = |direction: &DirectionSums| direction.sums().deviations.len() as u64;
        let bytes = self.directions.iter().map(entries).sum::<u64>() * size_of::<Entry>() as u64;
        if bytes <= MOST_EXITS {
            return Ok(());
        }
        let directions = self.directions.len();
        Err(Error::Failed(format!(
            "the directions in which rays leave take more than 1 GiB of memory for {directions} \
            directions of incidence; give fewer --incidence, --azimuth or --rays, a wider \
            --deviations MRAD for coarser bins, or --deviations off"
        )))
    }
}
