//! The program: arguments in, a verb run, text and files out.
//!
//! Arguments enter as a shell gives them. Printed text, written files and an exit code leave. Only
//! this module prints, reads the command line and ends the program.

mod by_hand;
#[cfg(feature = "full")]
pub mod calls;
mod estimate;
mod expected;
#[cfg(feature = "full")]
mod explore;
#[cfg(feature = "full")]
mod export;
mod failure;
#[cfg(feature = "full")]
mod forward;
mod host;
mod mtf;
mod output;
mod parse;
mod predict;
mod progress;
#[cfg(feature = "full")]
mod render;
mod sampled;
#[cfg(feature = "full")]
mod simulate;
#[cfg(feature = "full")]
mod study;
mod terms;
mod verbs;
#[cfg(feature = "full")]
mod view;

pub use verbs::main;
#[cfg(feature = "full")]
pub use view::render_view;
