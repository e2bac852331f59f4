//! TODO

pub mod azimuth;
pub mod bound;
pub mod campaign;
pub mod choice;
pub mod compared;
pub mod covariance;
pub mod error;
pub mod estimate;
pub mod facing;
pub mod forward;
pub mod joint;
pub mod layout;
pub mod loss;
pub mod optimum;
pub mod reference;
pub mod remarks;
pub mod scene;
pub mod select;
pub mod start;
pub mod verdict;
pub mod watch;
