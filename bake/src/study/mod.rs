//! Study of speed and error: every method, sampler and number of rays on one cell, compared with
//! the exact table.
//!
//! A request and a cell enter. Measured points and fitted slopes leave, and their report as text,
//! CSV, JSON or a picture. No file is written here.

mod fit;
pub(crate) mod picture;
pub(crate) mod report;
pub(crate) mod study;

pub use fit::{Reached, Slope};
#[cfg(test)]
pub(crate) use report::expected_exponent;
pub use study::{Reference, Series, Study, StudyPlan, StudyPoint, StudyRequest};
