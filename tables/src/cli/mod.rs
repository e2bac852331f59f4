//! What the command lines of `bake` and `fit` have in common (feature `cli`): lists of numbers, the formats of plots, outputs that
//! are reserved before the work, threads, printing, completions and manual pages.
//!
//! Text that a user typed enters; numbers, open outputs, or one [`Error`] leave. This room writes to the terminal, which no other
//! room of this crate does, and may touch [`crate::Outputs`].

mod list;
mod manual;
mod plot_format;
mod terminal;
mod threads;

pub use crate::cli::list::{LONGEST_LIST, ListError, list};
pub use crate::cli::manual::{completions, manual, version};
pub use crate::cli::plot_format::PlotFormat;
pub use crate::cli::terminal::{deliver, note, print, reserve, reserve_plot, warn};
pub use crate::cli::threads::{NoThreads, pool};

use crate::error::output::OutputError;

/// Why something that both command lines do failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Standard output is full or gone. A closed pipe is no error: its reader has seen enough.
    #[error(
        "standard output cannot be written ({0}); check the pipe, free some space, or use -o where the verb has it"
    )]
    Stdout(std::io::Error),
    /// A file cannot be reserved or written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A plot of no known format.
    #[error("{}: the extension must be .png or .svg", .0.display())]
    PlotExtension(std::path::PathBuf),
    /// Threads could not be started.
    #[error(transparent)]
    Threads(#[from] NoThreads),
}
