//! TODO

pub mod azimuth;
pub mod bound;
pub mod covariance;
pub mod estimate;
pub mod forward;
pub mod joint;
pub mod layout;
pub mod loss;
pub mod reference;
pub mod scene;
pub mod select;
pub mod start;
