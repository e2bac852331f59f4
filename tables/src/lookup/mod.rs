//! One direction of a table, as it is or interpolated, and as it is seen from a distance.
//!
//! A table and two angles enter. A [`direction::Direction`] leaves, with its bins, polygons and
//! exit directions.

pub(crate) mod between;
pub(crate) mod course;
pub(crate) mod direction;
pub(crate) mod family;
pub(crate) mod grid_cell;
pub(crate) mod many;
pub(crate) mod moved;
pub(crate) mod passage;
pub(crate) mod sextants;
pub(crate) mod shape;
pub(crate) mod unfolded;
