//! The program and the library from outside.

mod cli;
mod library;
mod merge;
mod resume;
mod study;
