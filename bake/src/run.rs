//! The bake itself: runs of rays over all threads, integer sums, the table. Prints nothing.

use crate::exact::{self, ExactCell, ExactError};
use crate::kernel::Kernel;
use crate::plan::{Effort, Method, Plan, RAYS_PER_RANDOMISATION, Shard};
use crate::scene::Index;
use crate::sequence::Stream;
use crate::sheet::Sheet;
use crate::tally::{Bins, Sums, Tally};
use meshes::Cell;
use ndarray::{Array2, Array4, Array5};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};
use tables::{Fate, Provenance, Shards, Table};
use thiserror::Error;

/// Rays in one piece of work: enough to make adding its histogram cheap, few enough to spread over threads.
const RUN: u64 = 1 << 18;

/// Rays per randomisation in the first round of a bake to a tolerance; each round doubles them.
const FIRST_ROUND: u64 = 1 << 12;

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
struct Run {
    direction: usize,
    randomisation: usize,
    samples: Range<u64>,
}

/// Everything about one direction that its rays share.
struct Bundle {
    kernel: Kernel,
    streams: Vec<Stream>,
    sums: Mutex<Sums>,
}

/// Bakes `cell` as planned, by the method that the plan names; `auto` is the exact method where [`exact::prepare`]
/// takes the cell, else rays.
///
/// # Errors
/// As [`rays`]; [`RunError::Exact`] where the plan insists on the exact method and it does not take the cell.
pub fn bake(cell: &Cell, plan: &Plan, progress: &(dyn Fn(u64) + Sync)) -> Result<Table, RunError> {
    match (plan.method, exact::prepare(cell, &plan.axes)) {
        (Method::Rays, _) | (Method::Auto, Err(_)) => rays(cell, plan, progress),
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
    pool(plan)?.install(|| {
        let bundles = bundles(cell, plan, tracer);
        let bins = Bins::new(plan.axes.bins, plan.axes.range);
        match plan.effort {
            Effort::Rays(rays) => {
                let every: Vec<usize> = (0..bundles.len()).collect();
                let share = |randomisation: usize| {
                    let samples = share(rays, plan.randomisations, randomisation);
                    let Shard { number, of } = plan.shard.unwrap_or(WHOLE);
                    Shards::samples(number, of, samples)
                };
                run(&bundles, &bins, &every, &share, progress);
            }
            Effort::Tolerance(tolerance) => until(&bundles, &bins, plan, tolerance, progress)?,
        }
        Ok(table(cell, plan, bundles))
    })
}

/// Rays of randomisation number `which` when `rays` are shared by `among`.
fn share(rays: u64, among: usize, which: usize) -> u64 {
    let among = among as u64;
    rays / among + u64::from((which as u64) < rays % among)
}

fn bundles(cell: &Cell, plan: &Plan, tracer: Tracer) -> Vec<Bundle> {
    let sheet = Sheet::new(cell, Index::Auto);
    let bins = Bins::new(plan.axes.bins, plan.axes.range);
    let rules = plan.rules(cell);
    let directions = plan
        .axes
        .incidence_deg
        .iter()
        .flat_map(|&i| plan.axes.azimuth_deg.iter().map(move |&a| (i, a)));
    directions
        .map(|(incidence_deg, azimuth_deg)| Bundle {
            kernel: {
                let kernel = Kernel::over(&sheet, &rules, &bins, incidence_deg, azimuth_deg);
                match tracer {
                    Tracer::Fastest => kernel,
                    Tracer::OneByOne => kernel.one_by_one(),
                }
            },
            streams: (0..plan.randomisations as u64)
                .map(|r| Stream::new(plan.sampler, plan.seed, incidence_deg, azimuth_deg, r))
                .collect(),
            sums: Mutex::new(Sums::new(&bins, plan.randomisations)),
        })
        .collect()
}

/// Traces the samples `share(randomisation)` of every randomisation of the directions named.
fn run(
    bundles: &[Bundle],
    bins: &Bins,
    directions: &[usize],
    share: &(dyn Fn(usize) -> Range<u64> + Sync),
    progress: &(dyn Fn(u64) + Sync),
) {
    let mut runs = Vec::new();
    for &direction in directions {
        for randomisation in 0..bundles[direction].streams.len() {
            let Range { start, end } = share(randomisation);
            let cuts = (start..end).step_by(RUN as usize);
            runs.extend(cuts.map(|from| Run {
                direction,
                randomisation,
                samples: from..end.min(from + RUN),
            }));
        }
    }
    runs.par_iter().for_each_init(
        || Tally::new(bins),
        |tally, run| {
            let bundle = &bundles[run.direction];
            tally.clear();
            bundle.kernel.trace(
                &bundle.streams[run.randomisation],
                run.samples.clone(),
                tally,
            );
            // Nothing can panic while the lock is held, so a poisoned lock still guards whole sums.
            bundle
                .sums
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .add(run.randomisation, tally);
            progress(run.samples.end - run.samples.start);
        },
    );
}

/// Doubles the rays of each direction until its estimated error is below `tolerance`.
fn until(
    bundles: &[Bundle],
    bins: &Bins,
    plan: &Plan,
    tolerance: f64,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<(), RunError> {
    let mut open: Vec<usize> = (0..bundles.len()).collect();
    let mut samples = 0..FIRST_ROUND;
    while !open.is_empty() {
        if samples.end > RAYS_PER_RANDOMISATION {
            let worst = open[0];
            let sums = bundles[worst]
                .sums
                .lock()
                .unwrap_or_else(PoisonError::into_inner);
            return Err(RunError::Tolerance {
                incidence_deg: plan.axes.incidence_deg[worst / plan.axes.azimuth_deg.len()],
                azimuth_deg: plan.axes.azimuth_deg[worst % plan.axes.azimuth_deg.len()],
                reached: sums.l1_error(),
                rays: sums.rays(),
            });
        }
        let round = samples.clone();
        run(bundles, bins, &open, &|_| round.clone(), progress);
        let error = |direction: usize| {
            bundles[direction]
                .sums
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .l1_error()
        };
        let errors: Vec<f64> = open.par_iter().map(|&direction| error(direction)).collect();
        open = open
            .into_iter()
            .zip(errors)
            .filter(|(_, error)| *error >= tolerance)
            .map(|(d, _)| d)
            .collect();
        samples = samples.end..samples.end * 2;
    }
    Ok(())
}

fn table(cell: &Cell, plan: &Plan, bundles: Vec<Bundle>) -> Table {
    let axes = plan.axes.clone();
    let ((ni, na), nb, nr) = (axes.shape(), axes.bins, plan.randomisations);
    let mut counts = Array5::zeros((ni, na, nr, nb, nb));
    let mut fates = Array4::zeros((ni, na, nr, Fate::ALL.len()));
    let by_direction = counts.exact_chunks_mut((1, 1, nr, nb, nb)).into_iter();
    let fates_by_direction = fates
        .exact_chunks_mut((1, 1, nr, Fate::ALL.len()))
        .into_iter();
    for ((bundle, mut counts), mut fates) in bundles
        .into_iter()
        .zip(by_direction)
        .zip(fates_by_direction)
    {
        let sums = bundle
            .sums
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner);
        counts
            .iter_mut()
            .zip(sums.counts)
            .for_each(|(count, sum)| *count = sum);
        fates
            .iter_mut()
            .zip(sums.fates.into_iter().flatten())
            .for_each(|(count, sum)| *count = sum);
    }
    let provenance = provenance(cell, plan, "rays".into(), plan.sampler.name().into());
    Table::from_counts(axes, counts, fates, provenance)
}

/// Where a table of `cell` baked by `method` comes from.
pub fn provenance(cell: &Cell, plan: &Plan, method: String, sampler: String) -> Provenance {
    Provenance {
        generator: concat!("bake ", env!("CARGO_PKG_VERSION")).into(),
        design: cell.design.clone(),
        mesh_hash: cell.mesh_hash.clone(),
        edge_length: cell.edge_length,
        edge_length_unit: "file unit".into(),
        azimuth_zero: cell.azimuth_zero.to_array(),
        refractive_index: plan.index_of(cell),
        back: plan.back.name().into(),
        losses: "none".into(),
        reflectance: 1.0,
        method,
        sampler,
        seed: plan.seed,
        angular_tolerance_deg: plan.angular_tolerance_deg,
        tolerance: match plan.effort {
            Effort::Tolerance(tolerance) => tolerance,
            Effort::Rays(_) => 0.0,
        },
        lattice: cell
            .entrance
            .lattice
            .map(|lattice| lattice.map(|vector| vector.to_array())),
        shards: match (plan.shard, plan.effort) {
            (Some(Shard { number, of }), Effort::Rays(rays)) => Some(Shards {
                of,
                rays,
                held: [number].into(),
            }),
            _ => None,
        },
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
