//! One direction of a table: exactly, or interpolated between those around it, and as it is seen
//! from a distance.
//!
//! A table and two angles enter; a [`direction::Direction`] leaves, with its bins, polygons and
//! exit directions. It touches the table and the errors.

pub(crate) mod between;
pub(crate) mod direction;
pub(crate) mod moved;
