//! TODO

pub mod lobe;
pub mod quantile;
pub mod sample;
pub mod sampled;
pub mod sequence;
pub mod shift;
