//! Why a bake fails.

use crate::cell::ExactError;
use tables::cli::NoThreads;
use thiserror::Error;

/// Why a bake failed.
#[derive(Debug, Error)]
pub enum RunError {
    /// The threads could not be started.
    #[error(transparent)]
    Threads(#[from] NoThreads),
    /// The cell or the directions are not for the exact method.
    #[error("--method exact: {0}")]
    Exact(#[from] ExactError),
    /// Something else was saved.
    #[error(
        "the bake that was saved is another one (its mesh, directions or options differ); repeat \
        the options that it began with, or leave out --resume"
    )]
    Saved,
    /// A share of what has no samples.
    #[error(
        "--shard: the exact method takes this cell and traces no rays to share out; leave out \
        --shard, or give --method \
         rays"
    )]
    ShardOfExact,
    /// Directions are chosen by what the exact method finds.
    #[error(
        "--direction-tolerance: {0}, and only exact tables are interpolated to a tolerance; give \
        --incidence and --azimuth \
         as lists instead"
    )]
    DirectionsOfRays(#[source] ExactError),
    /// The distribution jumps.
    #[error(
        "--direction-tolerance: with {directions} directions the table is still {reached:.2e} off \
        at incidence {incidence_deg} deg, \
         azimuth {azimuth_deg} deg, as where total reflection ends or slits of a plate change \
         places; leave such angles out, or give a tolerance above that"
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
        "the exit directions of {directions} directions of incidence take more than 1 GiB; give \
        fewer --incidence, --azimuth or \
         --rays, a wider --deviations MRAD for coarser bins, or --deviations off"
    )]
    Exits {
        /// Directions of the table.
        directions: usize,
    },
    /// The tolerance is out of reach.
    #[error(
        "the estimated L1 error at incidence {incidence_deg} deg, azimuth {azimuth_deg} deg is \
        still {reached:.2e} \
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
    /// The caller asked for it.
    #[error("the bake was stopped before its end")]
    Stopped,
}
