//! TODO

pub mod cli;
pub mod estimate;
pub mod evaluate;
pub mod export;
pub mod forward;
pub mod mtf;
pub mod predict;
pub mod render;
pub mod sampled;
pub mod simulate;
pub mod study;
pub mod terms;
