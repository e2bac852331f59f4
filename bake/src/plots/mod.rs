//! TODO

pub mod exits;
pub mod plot;
