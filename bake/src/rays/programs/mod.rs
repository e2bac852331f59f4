//! Cells of few facets as programs, which take many rays of one direction through all of their
//! paths side by side.

pub(crate) mod exits;
pub(crate) mod lanes;
pub(crate) mod program;
pub(crate) mod region;
pub(crate) mod scratch;
