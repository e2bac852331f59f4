//! The request for a bake: the options as typed, checked, with every default.
//!
//! A [`request::Request`] enters. Either a [`plan::Plan`] leaves, in which nothing is out of range,
//! or a [`crate::Error`] that names the option and the remedy. Nothing changes a plan after that.
//! Its warnings and some of its answers depend on the cell.

pub(crate) mod default;
mod deviations;
mod directions;
mod effort;
pub(crate) mod heading;
mod losses;
mod plan;
pub(crate) mod request;
#[cfg(test)]
mod tests;

pub(crate) use effort::{Effort, Shard};
pub(crate) use effort::{MOST_BYTES, RAYS_PER_RANDOMISATION};
pub(crate) use plan::INDEX_LEFT_OUT;
pub use plan::Plan;
pub use request::Request;
