//! Polygons of the plane, and the starts of rays: the points of a sequence, and the points of the
//! entrance that they become.
//!
//! Polygons are in the unit of their corners. A seed, a direction and an index give coordinates of
//! the unit square and a point of the entrance, the same in every run.

mod launch;
pub(crate) mod polygon;
mod sequence;

pub(crate) use launch::{Launch, Piece};
pub(crate) use polygon::{HalfPlane, Polygon};
pub(crate) use sequence::{
    FOURTH_REVERSED, Stream, centred, centres_below, pascal, philox, scramble,
};
