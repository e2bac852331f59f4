//! Prediction of what a fitted sheet shows at other distances and directions.
//!
//! A result and a table of its cell enter. MTF curves and luminances leave.

mod curve;
mod domain;
mod interval;
mod legibility;
mod prediction;
mod sheet;

pub use domain::{NEAR_MM, Viewpoint, between, remarks};
pub use legibility::{Criterion, Legibility, Letter, Limit, Viewing, legibility};
pub use prediction::Axis;
pub use prediction::{Around, around};
pub use prediction::{Places, Prediction, predict};
pub use sheet::Fitted;
