//! The outside view: photographs with a planted answer, and how good estimates of them are.
//!
//! [`simulate`] and [`tracer`] share names and tables with the estimator, and neither transforms nor
//! models. [`study`] estimates what they make, and [`plan`] says which photographs to take. This crate is no part of the lean fitter. Its tests
//! are those of the estimator on planted campaigns.

#![forbid(unsafe_code)]

pub mod plan;
pub mod planted;
pub mod simulate;
pub mod study;
#[cfg(test)]
mod tests;
pub mod tracer;
