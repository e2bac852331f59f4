//! Proved bounds of the error of an interpolated table, for cells of convex pits, alone or in a
//! lattice.
//!
//! A cell, a patch of directions and what the table knows there enter. An upper bound of the error
//! in every direction of the patch leaves; see [`bound::bound`] for the statement and its proof.
//! This room may touch `geometry`, `optics`, `cell` and `plan`. It traces nothing: it looks at all
//! facet sequences of all directions of a patch at once.

mod bound;
mod crossing;
mod group;
mod guess;
mod leaves;
mod means;
mod moving;
mod pairs;
mod pits;
mod power;
mod returned;
mod series;
mod valleys;

pub(crate) use bound::{Proof, bound};
pub(crate) use pits::{Pit, pits};
pub(crate) use valleys::valleys;
#[cfg(test)]
pub(crate) use {leaves::leaves, moving::Patch, returned::Returned};
