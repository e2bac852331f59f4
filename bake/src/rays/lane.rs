//! Lanes: how many rays go side by side, and what is kept for each of them.

/// Rays of a bundle. Enough that the compiler keeps the loops over lanes and turns them into
/// vectors: with 16 or 32 it unrolls them first and shuffles (2.5 times slower); 128 is 20 % slower
/// again.
pub(crate) const LANES: usize = 64;

/// A number for each lane.
pub(crate) type Reals = [f64; LANES];

/// A set of rays: a word for each lane, of which the users of this file say what its bits mean.
pub(crate) type Mask = [u64; LANES];
