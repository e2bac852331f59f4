//! Pictures of a table: the histograms of shifts, and the directions of light that does not go
//! straight back.
//!
//! A [`tables::Table`] enters, and the bytes of a PNG or SVG file leave. This room touches no other
//! room and writes no file.

mod exits;
mod figure;
mod histograms;

pub(crate) use exits::exits;
pub(crate) use figure::{PlotError, render};
pub(crate) use histograms::histograms;
