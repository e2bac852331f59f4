//! Parametric cells: corner cubes with their errors, tiles of them, curved faces, plates and beads.
//!
//! Numbers enter and a mesh leaves, as a file would give it. Its hash is that of its OBJ text.

mod bead;
mod corner;
mod cube;
mod curved;
mod plate;
mod tile;

pub use bead::Bead;
pub use cube::{Design, Shape, list};
pub use plate::Plate;
