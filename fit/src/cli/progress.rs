//! Progress of a long study, shown on a terminal. Without the feature `report` nothing is shown.

#[cfg(feature = "report")]
use std::io::IsTerminal;

#[cfg(feature = "report")]
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Progress bar on standard error if that is a terminal.
pub(crate) struct Progress {
    #[cfg(feature = "report")]
    bar: ProgressBar,
}

impl Progress {
    /// Shows a bar for this many campaigns, none of them done.
    #[cfg(feature = "report")]
    pub(crate) fn of(campaigns: u64) -> Progress {
        let bar = ProgressBar::new(campaigns);
        if !std::io::stderr().is_terminal() {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        if let Ok(style) =
            ProgressStyle::with_template("{bar:40} {pos}/{len} campaigns, {eta} left")
        {
            bar.set_style(style);
        }
        Progress { bar }
    }

    /// Shows nothing.
    #[cfg(not(feature = "report"))]
    pub(crate) fn of(_: u64) -> Progress {
        Progress {}
    }

    /// Counts one campaign as done.
    pub(crate) fn step(&self) {
        #[cfg(feature = "report")]
        self.bar.inc(1);
    }

    /// Removes the bar.
    pub(crate) fn done(&self) {
        #[cfg(feature = "report")]
        self.bar.finish_and_clear();
    }
}
