//! What a fitted sheet would show at other distances and directions.
//!
//! A result and a table of its cell enter; MTF curves and luminances leave, or the nearest lobe for renderers. The room
//! may touch results, the model and the numerics below it, and draws nothing.

pub mod error;
pub mod export;
pub mod prediction;
pub mod sheet;
