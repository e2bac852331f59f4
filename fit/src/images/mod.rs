//! TODO

pub mod metrics;
pub mod plane;
pub mod render;
pub mod sheet;
pub mod spot;
