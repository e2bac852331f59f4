//! The bake itself: which method, its errors, the table. Prints nothing.

use crate::beams::exact;
use crate::beams::exact::{ExactCell, ExactError};
use crate::plan::plan::{Effort, Method, Plan, Record, SceneOptions};
use crate::rays::scene::Index;
use crate::rays::sheet::Sheet;
use crate::rays::tally::Bins;
use crate::run::provenance::provenance;
use crate::run::ranks::{Alone, Ranks};
use crate::run::saves::Saves;
use crate::run::work::{Bundle, Rounds, Work};
use meshes::Cell;
use ndarray::Array2;
use tables::{Provenance, Table};
use thiserror::Error;

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
    /// Directions are chosen by what the exact method finds.
    #[error(
        "--direction-tolerance: {0}, and only exact tables are interpolated to a tolerance; give --incidence and --azimuth \
         as lists instead"
    )]
    DirectionsOfRays(#[source] ExactError),
    /// The distribution jumps.
    #[error(
        "--direction-tolerance: with {directions} directions the table is still {reached:.2e} off at incidence {incidence_deg} deg, \
         azimuth {azimuth_deg} deg, as where total reflection ends or slits of a plate change places; leave such angles out, or give a tolerance above that"
    )]
    DirectionTolerance {
        /// Incidence of the worst direction, degrees.
        incidence_deg: f64,
        /// Its azimuth, degrees.
        azimuth_deg: f64,
        /// The total variation there.
        reached: f64,
        /// Directions at most.
        directions: usize,
    },
    /// Exit directions of too many rays.
    #[error(
        "the exit directions of {directions} directions of incidence take more than 1 GiB; give fewer --incidence, --azimuth or \
         --rays, a wider --deviations MRAD for coarser bins, or --deviations off"
    )]
    Exits {
        /// Directions of the table.
        directions: usize,
    },
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

/// Bakes `cell` as planned, by the method that the plan names; `auto` is the exact method where [`prepared`] takes
/// the cell, else rays.
///
/// # Errors
/// As [`rays`]; [`RunError::Exact`] where the plan insists on the exact method and it does not take the cell.
pub fn bake(cell: &Cell, plan: &Plan, progress: &(dyn Fn(u64) + Sync)) -> Result<Table, RunError> {
    match exact_cell(cell, plan)? {
        None => rays(cell, plan, progress),
        Some(prepared) => beams(cell, &prepared, plan, progress),
    }
}

/// As [`bake`], shared by `ranks`, from where an interrupted bake was saved, and saved in its turn. Rank 0 gets the
/// table, the same as that of one process; the exact method is too short to be shared, and its alone.
///
/// # Errors
/// As [`bake`], and [`RunError::Saved`] where what was saved is of another bake: all in rank 0, but
/// [`RunError::Threads`] where it happens. The other ranks then wait for it, so that who fails must end them.
pub fn bake_from(
    cell: &Cell,
    plan: &Plan,
    progress: &(dyn Fn(u64) + Sync),
    saves: Option<Saves<'_>>,
    ranks: &dyn Ranks,
) -> Result<Option<Table>, RunError> {
    match exact_cell(cell, plan) {
        Ok(None) => {
            let work = traced(Tracer::Fastest, cell, plan, progress, saves, ranks)?;
            Ok(ranks.leads().then(|| work.table()))
        }
        _ if !ranks.leads() => Ok(None),
        Ok(Some(prepared)) => beams(cell, &prepared, plan, progress).map(Some),
        Err(error) => Err(error),
    }
}

/// The cell as the exact method takes it under the options of a plan.
///
/// # Errors
/// [`ExactError`]: why it does not.
pub fn prepared(cell: &Cell, plan: &Plan) -> Result<ExactCell, ExactError> {
    match crate::plan::scene::no_planes(&plan.scene) {
        Some(option) => Err(ExactError::NoPlanes { option }),
        None if plan.is_azimuth_mean() && plan.deviations(cell).is_some() => {
            Err(ExactError::MeanDeviates)
        }
        None => ExactCell::new(cell),
    }
}

/// The cell as the exact method takes it; `None` where rays are traced.
fn exact_cell(cell: &Cell, plan: &Plan) -> Result<Option<ExactCell>, RunError> {
    match (plan.method, prepared(cell, plan)) {
        (Method::Rays, _) | (Method::Auto, Err(_)) => Ok(None),
        (_, Ok(_)) if plan.shard.is_some() => Err(RunError::ShardOfExact),
        (_, Ok(prepared)) => Ok(Some(prepared)),
        (Method::Exact, Err(refusal)) => Err(refusal.into()),
    }
}

/// The exact bake. Whatever is asked of rays (number, tolerance, sampler, seed) has no part in the table.
pub(crate) fn beams(
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
        deviations: None,
        provenance: Provenance {
            seed: 0,
            tolerance: if plan.is_azimuth_mean() {
                exact::MEAN_ERROR
            } else {
                0.0
            },
            shards: None,
            // It says where each path goes, whatever is asked of rays.
            options: SceneOptions {
                deviations: Record::Auto,
                ..plan.scene
            }
            .into(),
            ..provenance(cell, plan, Method::Exact, None)
        },
    })
}

pub(crate) fn pool(plan: &Plan) -> Result<rayon::ThreadPool, RunError> {
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
    Ok(traced(tracer, cell, plan, progress, None, &Alone)?.table())
}

fn traced<'a>(
    tracer: Tracer,
    cell: &'a Cell,
    plan: &'a Plan,
    progress: &'a (dyn Fn(u64) + Sync),
    saves: Option<Saves<'_>>,
    ranks: &'a dyn Ranks,
) -> Result<Work<'a>, RunError> {
    let work = Work {
        cell,
        plan,
        tracer,
        sheet: Sheet::new(cell, Index::Auto),
        rules: plan.rules(cell),
        bins: Bins::new(plan.axes.bins, plan.axes.range),
        exits: plan.deviations(cell),
        bundles: Bundle::all(plan),
        progress,
        pool: pool(plan)?,
    };
    let mut rounds = Rounds { work, ranks, saves };
    rounds.go_on()?;
    match plan.effort {
        Effort::Rays(rays) => rounds.all(rays)?,
        Effort::Tolerance(tolerance) => rounds.until(tolerance)?,
    }
    Ok(rounds.work)
}
