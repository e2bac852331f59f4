//! Lanes: the number of rays that go side by side, and the values of each of them.

/// Number of rays of a bundle.
///
/// It is large enough that the compiler keeps the loops over lanes and turns them into vectors.
/// With 16 or 32 lanes the compiler unrolls the loops first and shuffles, which is 2.5 times
/// slower. With 128 lanes a bundle is 20 % slower.
pub(crate) const LANES: usize = 64;

/// Number for each lane.
pub(crate) type Reals = [f64; LANES];

/// Set of rays, one word for each lane; the user of the type defines the meaning of the bits.
pub(crate) type Mask = [u64; LANES];
