//! Pictures of a table: the shifts, and the directions of light that does not go straight back.
//!
//! A [`tables::Table`] enters, and SVG leaves. This room touches no other room but the polygons of
//! `geometry`, and writes no file.

mod choice;
mod exits;
mod heat;
mod shifts;

pub(crate) use exits::exits;
pub(crate) use shifts::shifts;
