//! Pictures of a table as SVG: the shifts, and the directions of light that does not go straight
//! back. No file is written here.

mod choice;
mod exits;
mod heat;
mod shifts;

pub(crate) use exits::exits;
pub(crate) use shifts::shifts;
