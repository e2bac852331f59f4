//! TODO

pub mod deviations;
pub mod directions;
pub mod error;
pub mod glass;
pub mod losses;
pub mod plan;
pub mod request;
pub mod scene;
#[cfg(test)]
mod tests;
