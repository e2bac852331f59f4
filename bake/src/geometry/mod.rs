//! Polygons of the plane: areas, clipping, differences, hulls.
//!
//! Corners enter, and polygons, areas or lists of convex parts leave, in whatever unit the corners
//! had. This is the ground: it touches no other room.

pub(crate) mod polygon;

pub(crate) use polygon::{HalfPlane, Polygon};
