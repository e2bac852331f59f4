//! Comparison of a model with a photograph, both seen through the photograph's own estimator.
//!
//! A measured edge and a model's curve enter. Differences of MTFs in units of their noise, the two
//! plateaus, or the likelihood of the pixels leave. The room compares one photograph at a time
//! and fits nothing but its nuisances: place, angle, plateaus and light. It may touch `model`,
//! `photographs` and `numerics`.

mod light;
mod likelihood;
mod pixels;
mod place;
mod reflectance;
mod remainder;
mod view;

#[cfg(test)]
pub(crate) use light::Terms;
pub(crate) use light::are_uneven;
#[cfg(test)]
pub(crate) use likelihood::Nuisances;
pub(crate) use likelihood::{Curves, Fitted, Photograph};
pub(crate) use pixels::Pixels;
pub(crate) use reflectance::Contrast;
pub(crate) use remainder::Remainder;
pub(crate) use view::{View, Weights};
