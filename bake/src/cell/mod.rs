//! TODO

pub mod bodies;
pub mod planes;
pub mod symmetry;
