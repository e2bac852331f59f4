//! Samples of the blur: where rays that left one point of the source meet the aerial image.
//!
//! A sample is a pure function of (seed, stream, index): four coordinates of a [`sequence`], the first two of which become a
//! ray shift ([`shift`]), the last two an offset by diffraction ([`lobe`]). Both are inversions, piecewise smooth in the
//! coordinates, so that evenly spread points give evenly spread samples. The sequence is this crate's own: `bake` has one
//! for two dimensions and a direction's angles, and `fit` does not depend on it.

pub use crate::samples::lobe::LobeSampler;
pub use crate::samples::quantile::Quantile;
pub use crate::samples::sequence::{Points, Sequence};
pub use crate::samples::shift::{Departure, ShiftSampler};
