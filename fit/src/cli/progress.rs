//! How far a long study is, on a terminal; nothing without the feature `report`.

#[cfg(feature = "report")]
use std::io::IsTerminal;

#[cfg(feature = "report")]
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A bar that a person sees; a pipe stays quiet.
pub(crate) struct Progress {
    #[cfg(feature = "report")]
    bar: ProgressBar,
}

impl Progress {
    /// A bar of this many campaigns, at none.
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

    /// Nothing that is seen.
    #[cfg(not(feature = "report"))]
    pub(crate) fn of(_: u64) -> Progress {
        Progress {}
    }

    /// One campaign is done.
    pub(crate) fn step(&self) {
        #[cfg(feature = "report")]
        self.bar.inc(1);
    }

    /// All are done; the bar goes.
    pub(crate) fn done(&self) {
        #[cfg(feature = "report")]
        self.bar.finish_and_clear();
    }
}
