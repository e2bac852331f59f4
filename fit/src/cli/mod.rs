//! The program: arguments in, a verb run, text and files out.
//!
//! Arguments enter as a shell gives them. Printed text, written files and an exit code leave. The
//! room may touch every other room of the crate. Only this room prints, reads the command line and
//! ends the program.

mod by_hand;
#[cfg(all(feature = "images", feature = "report"))]
pub mod calls;
mod estimate;
mod expected;
#[cfg(all(feature = "images", feature = "report"))]
mod explore;
mod export;
mod failure;
mod forward;
mod host;
mod mtf;
mod output;
mod parse;
mod predict;
mod progress;
#[cfg(feature = "images")]
mod render;
mod sampled;
mod simulate;
mod study;
mod terms;
mod verbs;
#[cfg(feature = "images")]
mod view;

pub use verbs::main;
#[cfg(feature = "images")]
pub use view::render_view;
