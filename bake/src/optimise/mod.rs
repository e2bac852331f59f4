//! The best cell for given views: edge length, cant, truncation, index and dihedral errors are
//! searched within bounds.
//!
//! A [`goal::Goal`] enters, read from TOML. An [`answer::Answer`] leaves: the best cell, or the front
//! between sharpness and light, with its check by rays and what small errors cost. Each cell is a
//! design of [`meshes::design`], followed exactly (`beams`). Nothing is printed or written.

mod answer;
mod candidate;
mod evolve;
mod goal;
pub(crate) mod report;

pub(crate) use answer::{Answer, optimise};
pub(crate) use goal::{Best, Goal};
#[cfg(test)]
pub(crate) use {candidate::Candidate, evolve::Merit, evolve::evolve};
