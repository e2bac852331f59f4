//! End-to-end tests of both programs and of the whole project.
//!
//! All of them are in one test program, so that the crates are linked only once.

#![allow(clippy::too_many_lines, reason = "a test is one list of cases")]

mod bakes;
mod files;
mod fits;
mod project;
mod shown;
