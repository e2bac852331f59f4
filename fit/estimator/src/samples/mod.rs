//! Samples of the blur: points where rays from one point of the source meet the mid-air image.
//!
//! A direction of a table and a lobe enter. Points leave, and the model of one photograph by
//! such points.
//!
//! A sample is a pure function of (seed, stream, index). A `sequence` gives four coordinates. The
//! first two become a ray shift (`shift`), the last two an offset by diffraction (`model::Lobe`). Both
//! maps are inversions and piecewise smooth in the coordinates, so evenly spread points give evenly
//! spread samples. The sequence is this crate's own: that of `bake` has two dimensions and the
//! angles of a direction, and `fit` does not depend on `bake`.

mod sampled;
mod sequence;
mod shift;

pub use sampled::has_samples;
pub use sampled::{Sampled, Sampling, Tile};
pub use sequence::Sequence;
pub use sequence::normals;
pub use sequence::{DIMENSIONS, Points};
pub use shift::ShiftSampler;
