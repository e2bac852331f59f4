//! Corner-cube cells: loading (OBJ, glTF/GLB), checking, normalising and designing meshes.
//!
//! A [`Mesh`] is what a file holds, in file units. A [`Cell`] is what the tracer needs: facets in the **cell frame**,
//! edge length 1, with the entrance, the lattice and the provenance.

pub mod cell;
pub mod mesh;

pub use cell::{Cell, Entrance};
pub use mesh::Mesh;
