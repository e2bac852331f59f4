//! Indexed triangles as a file holds them, and what can be wrong with them.
//!
//! Vertices and faces enter, polygons cut into triangles; a [`mesh::Mesh`] leaves in file units and
//! the file's frame, or an [`error::Fault`] that names the face. It touches no other room.

pub(crate) mod error;
pub(crate) mod mesh;
pub(crate) mod polygon;
