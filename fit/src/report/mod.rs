//! Output for people: pictures of curves, and the page in HTML (feature `report`).
//!
//! Results, predictions and studies enter. SVG, PNG and HTML leave as bytes. The room computes
//! nothing that a result does not hold, except the profiles of the likelihood. It may touch every
//! room but `cli`.

pub(crate) mod curves;
mod labels;
pub(crate) mod page;
pub(crate) mod picture;
pub(crate) mod plot;
pub(crate) mod speed;

pub(crate) use plot::Variable;
