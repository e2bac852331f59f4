//! From a mesh in file units to a cell in its own frame, edge length 1: welded, checked, turned,
//! with entrance and lattice.
//!
//! A mesh and the user's options enter. A [`cell::Cell`] leaves, or the fault of the mesh.

pub(crate) mod apex;
pub(crate) mod cell;
pub(crate) mod check;
pub(crate) mod entrance;
pub(crate) mod frame;
pub(crate) mod normalise;
pub(crate) mod normals;
pub(crate) mod prism;
pub(crate) mod rim;
pub(crate) mod rounding;
pub(crate) mod surface;
pub(crate) mod weld;
