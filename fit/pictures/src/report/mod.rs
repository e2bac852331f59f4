//! Output for people: plots, and the page of an estimate in HTML.
//!
//! Results, predictions and studies enter. SVG and HTML leave as text. All numbers are those of a
//! result, except the profiles of the likelihood.

pub mod page;
pub mod picture;
pub mod plot;

pub use plot::Variable;
