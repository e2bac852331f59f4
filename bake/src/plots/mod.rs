//! Pictures of a table: histograms of shifts, and where the light goes that does not come straight
//! back.
//!
//! A [`tables::Table`] enters; the bytes of a PNG or SVG file leave. This room touches no other,
//! and writes no file.

mod exits;
mod figure;
mod histograms;

pub(crate) use exits::exits;
pub(crate) use figure::{PlotError, render};
pub(crate) use histograms::histograms;
