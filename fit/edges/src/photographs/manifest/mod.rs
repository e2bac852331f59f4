//! The manifest of a campaign: which photographs there are, how they were taken, and in which light.

pub mod captures;
mod keys;
pub mod lamp;
pub(super) mod roi;
pub(super) mod setup;
