//! Progress of long work: a bar on a terminal, and now and then a line in a log. Without the feature
//! `full` there is no bar.

use std::io::{IsTerminal, Write};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

#[cfg(feature = "full")]
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use estimator::estimate::Step;

/// Time after which work is long enough for a line in a log, and from one line to the next.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// Progress on standard error: a bar if that is a terminal, else lines.
pub(crate) struct Bar {
    #[cfg(feature = "full")]
    bar: ProgressBar,
    log: Log,
}

/// Lines on standard error if that is no terminal.
struct Log {
    is_shown: bool,
    last: Mutex<Instant>,
}

impl Log {
    fn new() -> Log {
        Log {
            is_shown: !std::io::stderr().is_terminal(),
            last: Mutex::new(Instant::now()),
        }
    }

    /// Writes a line if the last one is old enough.
    fn part(&self, what: &str, done: usize, of: usize) {
        if !self.is_shown {
            return;
        }
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.elapsed() >= LINE_EVERY {
            *last = Instant::now();
            // Work does not fail because nobody reads of it.
            let _ = writeln!(std::io::stderr(), "{done} of {of} {what}");
        }
    }
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

    /// Shows a bar for the steps of an estimate, a render, a page or a comparison, see [`Bar::show`] and
    /// [`Bar::part`].
    #[cfg(feature = "full")]
    pub(crate) fn of_steps() -> Bar {
        Bar::with(0, "{bar:40} {pos}/{len} {msg}, {rate}, {eta} left")
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
        Bar {
            bar,
            log: Log::new(),
        }
    }

    /// Shows nothing.
    #[cfg(not(feature = "full"))]
    pub(crate) fn of(_: u64) -> Bar {
        Bar { log: Log::new() }
    }

    /// Shows the steps of an estimate in a log.
    #[cfg(not(feature = "full"))]
    pub(crate) fn of_steps() -> Bar {
        Bar { log: Log::new() }
    }

    /// Shows a step of an estimate that is done. Each kind of step has a bar of its own.
    pub(crate) fn show(&self, step: Step) {
        if let Some((what, done, of)) = step.words() {
            self.part(what, done, of);
        }
    }

    /// Shows that `done` pieces of a kind of work are done. Each kind has a bar of its own.
    pub(crate) fn part(&self, what: &'static str, done: usize, of: usize) {
        self.log.part(what, done, of);
        #[cfg(feature = "full")]
        self.draw(what, done, of);
    }

    #[cfg(feature = "full")]
    fn draw(&self, what: &'static str, done: usize, of: usize) {
        // The length comes first, so that no bar of length 0 is drawn.
        let is_other = self.bar.message() != what;
        self.bar.set_length(of as u64);
        if is_other {
            self.bar.reset();
            self.bar.set_message(what);
        }
        self.bar.set_position(done as u64);
    }

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
