//! TODO

pub mod choice;
pub mod forward;
pub mod ranges;
pub mod refused;
pub mod study;
pub mod summary;
pub mod trial;
