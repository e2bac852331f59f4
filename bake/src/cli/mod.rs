//! Command line of the program `bake`: one file for each verb, and what the verbs share.
//!
//! Words that a user typed enter. Text on stdout, warnings and a progress bar on stderr, and
//! tables, meshes and pictures on the disk leave. Every error leaves as one sentence and an exit
//! code. This room alone prints, reads a command line and chooses exit codes. It may touch every
//! other room.

pub mod calls;
mod cell;
#[allow(clippy::module_inception, reason = "the command line itself")]
mod cli;
mod compare;
mod design;
mod display;
mod host;
mod inspect;
mod merge;
mod report;
mod study;
mod trace;
mod verify;

pub use cli::main;
#[cfg(test)]
pub(crate) use report::comparison_text;
