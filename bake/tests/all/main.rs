//! Tests of the program and the library from outside.

#![allow(clippy::too_many_lines, reason = "a test is one list of cases")]

mod cli;
mod library;
mod merge;
mod program;
mod resume;
mod study;
