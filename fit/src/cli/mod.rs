//! The program: arguments in, a verb run, text and files out.
//!
//! Arguments enter as a shell gives them. Printed text, written files and an exit code leave. Only
//! this module prints, reads the command line and ends the program.

#[cfg(feature = "full")]
pub mod calls;
mod estimate;
mod failure;
mod host;
#[cfg(feature = "full")]
mod lab;
mod mtf;
mod options;
mod output;
#[cfg(feature = "full")]
mod pictures;
mod predict;
mod progress;
mod verbs;

#[cfg(feature = "full")]
pub use options::view::render_view;
pub use verbs::main;
