//! TODO

pub mod counted;
pub mod fit;
pub mod picture;
pub mod report;
pub mod study;
