//! Parts that the command lines of `bake` and `fit` share (feature `cli`).
//!
//! They are lists of numbers, outputs that are reserved before the work, threads,
//! printing, completions and manual pages.
//!
//! Text that a user typed enters. Numbers, reserved outputs or one [`crate::Error`] leave. This room
//! writes to the terminal, which no other room of this crate does. It may touch [`crate::Outputs`].

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
