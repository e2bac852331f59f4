//! Limits of what may be asked for.

/// Largest number of rays of a direction in one randomisation.
///
/// A scrambled sequence has no more distinct points.
pub(crate) const RAYS_PER_RANDOMISATION: u64 = 1 << 32;

/// Largest number of bins along an axis.
pub(crate) const BINS_LIMIT: usize = 4096;

/// Largest array of a table, bytes. A table with a larger one could not be read again.
pub(crate) const MOST_BYTES: u64 = 1 << 31;
