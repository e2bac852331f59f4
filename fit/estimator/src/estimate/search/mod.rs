//! The search for the terms and parameters that photographs support, and the results that follow.
//!
//! A scene enters. The chosen candidate leaves, with its parameters, their covariance and bounds.

pub(crate) mod azimuth;
pub mod bound;
pub(crate) mod compared;
pub(crate) mod covariance;
pub(crate) mod cubes;
pub mod fitted;
pub mod forward;
pub(crate) mod further;
pub(crate) mod hints;
pub(crate) mod joint;
pub mod layout;
pub mod loss;
pub mod optimum;
pub(crate) mod score;
pub mod select;
pub mod start;
mod tried;
