//! Where rays start: the points of a sequence, and the points of the entrance that they become.
//!
//! A seed, a direction and an index enter; coordinates of the unit square, then a point of the
//! entrance, leave. The same index gives the same point in every run. This room touches no other.

mod launch;
mod sequence;

pub(crate) use launch::{Launch, Piece};
pub(crate) use sequence::{Stream, centred, pascal, philox, scramble};
