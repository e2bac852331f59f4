//! TODO

pub mod page;
pub mod picture;
pub mod plot;
pub mod speed;
