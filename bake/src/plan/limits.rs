//! The most that may be asked for.

/// Rays of a direction in one randomisation at most: a scrambled sequence has that many distinct
/// points.
pub(crate) const RAYS_PER_RANDOMISATION: u64 = 1 << 32;

/// Bins along an axis at most.
pub(crate) const BINS_LIMIT: usize = 4096;

/// Directions of a table at most.
pub(crate) const DIRECTIONS_LIMIT: usize = 100_000;
