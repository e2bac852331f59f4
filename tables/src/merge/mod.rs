//! Adding the rays and the directions of tables.
//!
//! Tables of one cell enter. The table of the whole bake leaves, or the field, overlap or gap that
//! forbids it.

pub(crate) mod directions;
pub(crate) mod merge;
