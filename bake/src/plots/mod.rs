//! Pictures of a table: the shifts, and the directions of light that does not go straight back.
//!
//! A [`tables::Table`] enters, and the bytes of a PNG or SVG file leave. This room uses `geometry`
//! to cut polygons, touches no other room, and writes no file.

mod arrangement;
mod choice;
mod colours;
mod content;
mod exits;
mod figure;
mod panel;
mod shifts;

pub(crate) use exits::exits;
pub(crate) use figure::render;
pub(crate) use shifts::shifts;
