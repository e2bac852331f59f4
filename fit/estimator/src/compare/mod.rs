//! Comparison of a model with a photograph, both seen through the photograph's own estimator.
//!
//! A measured edge and a model's curve enter. Differences of MTFs in units of their noise, the two
//! plateaus, or the likelihood of the pixels leave. The module compares one photograph at a time
//! and fits nothing but its nuisances: place, angle, plateaus and light.

mod light;
mod likelihood;
mod pixels;
mod place;
mod reflectance;
mod remainder;
mod view;

pub use light::Terms;
pub use light::are_uneven;
pub use likelihood::Nuisances;
pub use likelihood::{Curves, FittedPhotograph, Photograph};
pub use pixels::Pixels;
pub use reflectance::Contrast;
pub use remainder::Remainder;
pub use view::{View, Weights};
