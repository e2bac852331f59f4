//! Polygons of the plane: areas, clipping, differences, hulls.
//!
//! Corners enter. Polygons, areas or lists of convex parts leave, in the unit of the corners. This
//! room is the ground and touches no other room.

pub(crate) mod polygon;

pub(crate) use polygon::{HalfPlane, Polygon};
