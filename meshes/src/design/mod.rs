//! Parametric cells: corner cubes with their errors, tiles of them, curved faces, plates and beads.
//!
//! Numbers enter and a mesh leaves, as a file would give it. It touches the mesh room, and the
//! files, whose text a design's hash is of.

mod bead;
mod corner;
mod cube;
mod curved;
mod option;
mod plate;
mod tile;

pub use bead::Bead;
pub use cube::{Design, Shape, list};
pub use plate::Plate;
