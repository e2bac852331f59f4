//! Parts that the command lines of `bake` and `fit` share (feature `cli`): lists of numbers,
//! reserved outputs, threads, printing, completions and manual pages.
//!
//! No other module of this crate writes to the terminal.

mod list;
mod manual;
mod terminal;
mod threads;
mod usage;

pub use crate::cli::list::{LONGEST_LIST, list, number, whole};
pub use crate::cli::manual::{Completions, Manual, version};
pub use crate::cli::terminal::{
    deliver, fail, in_a_line, note, print, reserve, reserve_plot, warn,
};
pub use crate::cli::threads::pool;
pub use crate::cli::usage::{Refused, parsed, sentence};
