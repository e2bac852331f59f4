//! A model beside a photograph, as the photograph's own estimator sees both.
//!
//! A measured edge and a model's curve enter; MTF differences in units of their noise, plateaus, or
//! the likelihood of the pixels leave. The room compares one photograph at a time and looks for
//! nothing but its nuisances: place, angle, plateaus, gradient. It may touch `model`, `photographs`
//! and `numerics`.

mod likelihood;
mod pixels;
mod place;
mod reflectance;
mod view;

#[cfg(test)]
pub(crate) use likelihood::Nuisances;
pub(crate) use likelihood::{Curves, Fitted, NUISANCES, Photograph, STEP};
pub(crate) use pixels::Pixels;
pub(crate) use reflectance::Contrast;
pub(crate) use view::{View, Weights};
