//! Indexed triangles as a file holds them, and their faults.
//!
//! Vertices and faces enter, polygons cut into triangles. A [`mesh::Mesh`] leaves in file units and
//! the file's frame, or an [`error::Fault`] that names the face.

pub(crate) mod digits;
pub(crate) mod error;
pub(crate) mod mesh;
pub(crate) mod polygon;
