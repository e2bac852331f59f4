//! Charts as SVG, in one look: figures that stand alone, and panels of a page.
//!
//! A [`Figure`] is laid out by itself: titles are wrapped, curves are named at their ends where
//! that fits and in one legend otherwise. A [`Panel`] draws what it is told to where it is told to,
//! with classes and no colours, so that the style sheet of a page makes it light, dark or printed.
//! This crate knows nothing of tables and of photographs, and writes no file.

mod axis;
#[cfg(any(test, feature = "check"))]
pub mod check;
mod colour;
mod facet;
mod figure;
mod image;
mod legend;
mod panel;
mod text;

pub use crate::axis::Axis;
pub use crate::colour::{HUES, PALETTE, STEPS, ramp};
pub use crate::facet::{Curve, Facet, Ground, Marks};
pub use crate::figure::Figure;
pub use crate::image::Image;
pub use crate::legend::{Bar, Dash, Key, Stroke};
pub use crate::panel::{Panel, svg};
pub use crate::text::{escape, minus};

/// Style sheet of charts within a page that defines the colours of [`PALETTE`].
pub const STYLE: &str = include_str!("style.css");
