//! The starts of rays: the points of a sequence, and the points of the entrance that they become.
//!
//! A seed, a direction and an index enter. Coordinates of the unit square and points of the
//! entrance leave. The same index gives the same point in every run.

mod launch;
mod sequence;

pub(crate) use launch::{Launch, Piece};
pub(crate) use sequence::{
    FOURTH_REVERSED, Stream, centred, centres_below, pascal, philox, scramble,
};
