//! Command line of the program `bake`: one file for each verb, and what the verbs share.
//!
//! This module alone prints, reads a command line and chooses exit codes. Results go to stdout,
//! warnings and a progress bar to stderr. Every error is one sentence and an exit code.

pub mod calls;
mod cell;
#[allow(clippy::module_inception, reason = "the command line itself")]
mod cli;
mod compare;
mod datasheet;
mod design;
mod display;
mod inspect;
mod merge;
mod optimise;
mod report;
mod study;
mod trace;
mod verify;

pub use cli::main;
#[cfg(test)]
pub(crate) use report::comparison_text;
