//! Output for people: pictures of curves, and the page in HTML (feature `report`).
//!
//! Results, predictions and studies enter. SVG and HTML leave as text. The room computes
//! nothing that a result does not hold, except the profiles of the likelihood. It may touch every
//! room but `cli`.

pub mod page;
pub mod picture;
pub mod plot;

pub use plot::Variable;
