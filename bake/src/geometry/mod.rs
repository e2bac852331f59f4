//! Polygons of the plane: areas, clipping, differences, hulls, in the unit of their corners.

pub(crate) mod polygon;

pub(crate) use polygon::{HalfPlane, Polygon};
