//! TODO

pub mod export;
pub mod predict;
