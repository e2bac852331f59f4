//! TODO

pub mod launch;
pub mod sequence;
