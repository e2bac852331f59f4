//! The program: arguments in, a verb run, text and files out.
//!
//! Arguments enter as a shell gives them. Printed text, written files and an exit code leave. Only
//! this module prints, reads the command line and ends the program.

#[cfg(feature = "full")]
pub mod calls;
#[cfg(feature = "full")]
mod compare;
mod estimate;
#[cfg(feature = "full")]
mod explore;
#[cfg(feature = "full")]
mod export;
mod failure;
mod host;
mod mtf;
mod options;
mod output;
#[cfg(feature = "full")]
mod plan;
mod predict;
mod progress;
#[cfg(feature = "full")]
mod render;
#[cfg(feature = "full")]
mod simulate;
#[cfg(feature = "full")]
mod study;
mod verbs;

#[cfg(feature = "full")]
pub use options::view::render_view;
pub use verbs::main;
