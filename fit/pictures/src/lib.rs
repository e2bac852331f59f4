//! What a person looks at: mid-air images, the page with sliders, plots and reports.
//!
//! - [`images`]: pictures through a sheet.
//! - [`compare`]: sheets side by side.
//! - [`explore`]: one page that computes mid-air images in a browser.
//! - [`export`]: the nearest lobe of a sheet for other renderers.
//! - [`plan`]: a planned campaign as a page to print.
//! - [`report`]: plots and the page of an estimate.

#![forbid(unsafe_code)]

pub mod compare;
mod error;
pub mod explore;
pub mod export;
pub mod images;
pub mod plan;
pub mod report;
#[cfg(test)]
mod tests;

pub use error::Error;
