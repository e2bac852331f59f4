//! TODO

pub mod likelihood;
pub mod pixels;
pub mod place;
pub mod reflectance;
pub mod view;
