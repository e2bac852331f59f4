//! TODO

pub mod polygon;
