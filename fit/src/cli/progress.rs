//! Progress of long work, shown on a terminal. Without the feature `full` nothing is shown.

#[cfg(feature = "full")]
use std::io::IsTerminal;

#[cfg(feature = "full")]
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use estimator::estimate::Step;

/// Progress bar on standard error if that is a terminal.
pub(crate) struct Bar {
    #[cfg(feature = "full")]
    bar: ProgressBar,
}

impl Bar {
    /// Shows a bar for this many campaigns, none of them done.
    #[cfg(feature = "full")]
    pub(crate) fn of(campaigns: u64) -> Bar {
        Bar::with(
            campaigns,
            "{bar:40} {pos}/{len} campaigns, {rate}, {eta} left",
        )
    }

    /// Shows a bar for the steps of an estimate or a render, see [`Bar::show`] and
    /// [`Bar::part`].
    #[cfg(feature = "full")]
    pub(crate) fn of_steps() -> Bar {
        Bar::with(0, "{bar:40} {pos}/{len} {msg}, {rate}, {eta} left")
    }

    /// Shows how many grids of a page have been tried, and for how long.
    #[cfg(feature = "full")]
    pub(crate) fn of_grids() -> Bar {
        Bar::with(0, "{spinner} grid {pos} tried, {elapsed}")
    }

    #[cfg(feature = "full")]
    fn with(length: u64, template: &str) -> Bar {
        let bar = ProgressBar::new(length);
        if !std::io::stderr().is_terminal() {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.with_key("rate", rate));
        }
        Bar { bar }
    }

    /// Shows nothing.
    #[cfg(not(feature = "full"))]
    pub(crate) fn of(_: u64) -> Bar {
        Bar {}
    }

    /// Shows nothing.
    #[cfg(not(feature = "full"))]
    pub(crate) fn of_steps() -> Bar {
        Bar {}
    }

    /// Shows a step of an estimate that is done. Each kind of step has a bar of its own.
    #[cfg(feature = "full")]
    pub(crate) fn show(&self, step: Step) {
        if let Some((what, done, of)) = step.words() {
            self.part(what, done, of);
        }
    }

    /// Shows that `done` pieces of a kind of work are done. Each kind has a bar of its own.
    #[cfg(feature = "full")]
    pub(crate) fn part(&self, what: &'static str, done: usize, of: usize) {
        if self.bar.message() != what {
            self.bar.set_message(what);
            self.bar.reset();
        }
        self.bar.set_length(of as u64);
        self.bar.set_position(done as u64);
    }

    /// Shows nothing.
    #[cfg(not(feature = "full"))]
    pub(crate) fn show(&self, _: Step) {}

    /// Shows nothing.
    #[cfg(not(feature = "full"))]
    pub(crate) fn part(&self, _: &'static str, _: usize, _: usize) {}

    /// Counts one campaign as done.
    pub(crate) fn step(&self) {
        #[cfg(feature = "full")]
        self.bar.inc(1);
    }

    /// Removes the bar.
    pub(crate) fn done(&self) {
        #[cfg(feature = "full")]
        self.bar.finish_and_clear();
    }
}

/// Writes the mean number of steps a second, with three digits.
#[cfg(feature = "full")]
fn rate(state: &ProgressState, out: &mut dyn std::fmt::Write) {
    let seconds = state.elapsed().as_secs_f64();
    if seconds < 0.1 {
        let _ = out.write_str("...");
        return;
    }
    let rate = state.pos() as f64 / seconds;
    let decimals = (2.0 - rate.max(1.0).log10().floor()).max(0.0) as usize;
    let _ = write!(out, "{rate:.decimals$}/s");
}
