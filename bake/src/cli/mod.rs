//! The program `bake`: one file a verb, what they share, and every error as one sentence and an
//! exit code.
//!
//! Words that a user typed enter; text on stdout, warnings and a progress bar on stderr, tables,
//! meshes and pictures on the disk leave. This room alone prints, reads a command line and chooses
//! exit codes. It may touch every other room.

mod cell;
#[allow(clippy::module_inception, reason = "the command line itself")]
mod cli;
mod compare;
mod design;
mod failure;
mod inspect;
mod merge;
mod progress;
mod report;
mod study;
mod trace;
mod verify;

pub use cli::main;
#[cfg(test)]
pub(crate) use report::comparison_text;
