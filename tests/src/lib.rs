//! Helpers of the end-to-end tests: they start the two programs, find the project's files, and
//! compare results with truths.

#![forbid(unsafe_code)]

pub mod browser;
pub mod estimate;
pub mod files;
pub mod page;
pub mod program;
