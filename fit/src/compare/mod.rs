//! A model beside a photograph, as the photograph's own estimator sees both.
//!
//! A measured edge and a model's curve enter; MTF differences in units of their noise, plateaus, or the likelihood of the pixels
//! leave. The room compares one photograph at a time and looks for nothing but its nuisances: place, angle, plateaus, gradient. It may
//! touch `model`, `photographs` and `numerics`.

pub mod likelihood;
pub mod pixels;
pub mod place;
pub mod reflectance;
pub mod view;
