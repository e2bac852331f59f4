//! The program: arguments in, a verb run, text and files out.
//!
//! Arguments enter as a shell gives them; printed text, written files and an exit code leave. The room may touch every
//! other room of the crate. It alone prints, reads the command line and ends the program.

pub mod estimate;
#[cfg(feature = "images")]
pub mod evaluate;
pub mod export;
pub mod failure;
pub mod forward;
pub mod mtf;
pub mod output;
pub mod parse;
pub mod predict;
pub mod progress;
#[cfg(feature = "images")]
pub mod render;
pub mod sampled;
pub mod simulate;
pub mod study;
pub mod terms;
mod verbs;

pub use verbs::main;
