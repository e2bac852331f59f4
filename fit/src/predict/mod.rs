//! Prediction of what a fitted sheet shows at other distances and directions.
//!
//! A result and a table of its cell enter. MTF curves and luminances leave, or the nearest lobe for
//! renderers. The room may touch results, the model and the numerics below it. It draws nothing.

mod curve;
mod domain;
pub(crate) mod error;
mod export;
mod interval;
mod prediction;
mod sheet;

pub(crate) use domain::{NEAR_MM, Viewpoint, between, remarks};
pub(crate) use error::Error;
#[cfg(test)]
pub(crate) use export::Nearest;
pub(crate) use export::{Form, LOST, nearest};
pub(crate) use prediction::Axis;
pub(crate) use prediction::{Around, around};
pub use prediction::{Places, Prediction, predict};
pub(crate) use sheet::Fitted;
