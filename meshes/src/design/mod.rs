//! Parametric cells: corner cubes with their errors, tiles of them, curved faces, plates and beads.
//!
//! Numbers enter and a mesh leaves, as a file would give it. Its hash is that of its OBJ text.

mod corner;
mod cube;
mod curved;
mod elements;
mod tile;

pub use cube::{Design, Shape, list};
pub use elements::{Bead, Plate};
