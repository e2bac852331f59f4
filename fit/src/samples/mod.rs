//! Samples of the blur: where rays that left one point of the source meet the aerial image.
//!
//! A direction of a table and a lobe enter; points leave, and one photograph's model by such
//! points. The room may touch the model, the photographs' profiles and the numerics.
//!
//! A sample is a pure function of (seed, stream, index): four coordinates of a [`sequence`], the
//! first two of which become a ray shift ([`shift`]), the last two an offset by diffraction
//! ([`lobe`]). Both are inversions, piecewise smooth in the coordinates, so that evenly spread
//! points give evenly spread samples. The sequence is this crate's own: `bake` has one for two
//! dimensions and a direction's angles, and `fit` does not depend on it.

mod lobe;
mod quantile;
mod sampled;
mod sequence;
mod shift;

pub(crate) use lobe::LobeSampler;
pub(crate) use sampled::has_samples;
pub(crate) use sampled::{Sampled, Sampling, Tile};
pub(crate) use sequence::Sequence;
pub(crate) use sequence::{DIMENSIONS, Points};
pub(crate) use shift::ShiftSampler;
