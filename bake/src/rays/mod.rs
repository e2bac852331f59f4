//! TODO

pub mod bundle;
pub mod bvh;
pub mod kernel;
pub mod lanes;
pub mod packet;
pub mod path;
pub mod program;
pub mod scene;
pub mod sheet;
pub mod simd;
pub mod tally;
