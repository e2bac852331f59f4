//! Reasons why a bake fails.

use crate::cell::ExactError;
use tables::cli::NoThreads;
use thiserror::Error;

/// Reason why a bake failed.
#[derive(Debug, Error)]
pub enum RunError {
    /// Threads that could not be started.
    #[error(transparent)]
    Threads(#[from] NoThreads),
    /// Cell or directions that the exact method cannot bake.
    #[error("--method exact: {0}")]
    Exact(#[from] ExactError),
    /// Saved state of another bake.
    #[error(
        "the bake that was saved is another one (its mesh, directions or options differ); repeat \
        the options that it began with, or leave out --resume"
    )]
    Saved,
    /// Share of the samples of an exact bake, which has no samples.
    #[error(
        "--shard: this cell is baked by the exact method, which traces no rays, so there is \
        nothing to share; leave out --shard, or give --method rays"
    )]
    ShardOfExact,
    /// Tolerance between directions for a cell that the exact method cannot bake.
    #[error(
        "--direction-tolerance: {0}, and only exact tables are interpolated to a tolerance; give \
        --incidence and --azimuth as lists instead"
    )]
    DirectionsOfRays(#[source] ExactError),
    /// Tolerance between directions that is not reached, because the distribution jumps.
    #[error(
        "--direction-tolerance: with {directions} directions {} at \
        incidence {incidence_deg} deg, azimuth {azimuth_deg} deg; ray shifts may jump there, for \
        example because total reflection ends or slits of a plate change places; leave out such \
        angles, or give a greater tolerance",
        still(*reached, *aim)
    )]
    DirectionTolerance {
        /// Incidence of the worst direction, degrees.
        incidence_deg: f64,
        /// Azimuth of that direction, degrees.
        azimuth_deg: f64,
        /// Total variation reached in that direction; `None` if its polygons cannot be
        /// interpolated.
        reached: Option<f64>,
        /// Total variation that was aimed at there, below the tolerance.
        aim: f64,
        /// Largest number of directions.
        directions: usize,
    },
    /// Counts of rays that take more memory than a table may.
    #[error(
        "the rays of {directions} directions are counted in {bins} x {bins} bins and \
        {randomisations} randomisations, which take more than 2 GiB; give fewer --bins, \
        --incidence or --azimuth"
    )]
    Counts {
        /// Number of directions of the table.
        directions: usize,
        /// Number of bins along an axis.
        bins: usize,
        /// Number of independent randomisations.
        randomisations: usize,
    },
    /// Exit directions of so many rays that they do not fit in memory.
    #[error(
        "the directions in which rays leave take more than 1 GiB of memory for {directions} \
        directions of incidence; give fewer --incidence, --azimuth or --rays, a wider \
        --deviations MRAD for coarser bins, or --deviations off"
    )]
    Exits {
        /// Number of directions of the table.
        directions: usize,
    },
    /// Tolerance of the histograms that is not reached with the most rays possible.
    #[error(
        "the estimated L1 error at incidence {incidence_deg} deg, azimuth {azimuth_deg} deg is \
        still {reached:.2e} after {rays} rays; give a --tolerance above that, or fewer --bins"
    )]
    Tolerance {
        /// Incidence of the worst direction, degrees.
        incidence_deg: f64,
        /// Azimuth of that direction, degrees.
        azimuth_deg: f64,
        /// Estimated L1 error reached.
        reached: f64,
        /// Number of rays spent on that direction.
        rays: u64,
    },
    /// Stop that the caller asked for.
    #[error("the bake was stopped before its end")]
    Stopped,
}

/// Returns what is still wrong with an interpolated direction.
fn still(reached: Option<f64>, aim: f64) -> String {
    match reached {
        Some(error) => format!(
            "the error is still {error:.3e}, above the {aim:.3e} that the search aims at because \
            it tries only some of all directions,"
        ),
        None => "the polygons can still not be interpolated".into(),
    }
}
