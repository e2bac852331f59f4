//! The progress bar: on a terminal only.

use crate::plan::Effort;
use crate::run::Bake;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;

/// A bar on stderr that counts rays; silent where stderr is no terminal.
pub(super) struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar as long as the bake's rays; without an end where it runs to a tolerance.
    /// One that is not `shown` counts in silence.
    pub(super) fn new(bake: &Bake, shown: bool) -> Self {
        let (incidences, azimuths) = bake.axes().shape();
        let (bar, template) = match bake.plan.effort {
            Effort::Rays(rays) => {
                let bar = ProgressBar::no_length();
                bar.set_length(rays.saturating_mul((incidences * azimuths) as u64));
                (
                    bar,
                    "{bar:40} {human_pos}/{human_len} rays, {per_sec}, {eta} left",
                )
            }
            Effort::Tolerance(_) => (
                ProgressBar::no_length(),
                "{spinner} {human_pos} rays, {per_sec}",
            ),
        };
        if !shown || !std::io::stderr().is_terminal() {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        Progress { bar }
    }

    /// A bar over the bakes of a study, which names the one that runs.
    pub(super) fn of_study() -> Self {
        let bar = ProgressBar::no_length();
        if !std::io::stderr().is_terminal() {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} {msg}") {
            bar.set_style(style);
        }
        Progress { bar }
    }

    /// The bake called `name` begins, after `done` of `all`.
    pub(super) fn step(&self, name: &str, done: usize, all: usize) {
        self.bar.set_length(all as u64);
        self.bar.set_position(done as u64);
        self.bar.set_message(name.to_owned());
    }

    /// Counts rays; may be called from any thread.
    pub(super) fn advance(&self, rays: u64) {
        self.bar.inc(rays);
    }

    /// Takes the bar off the terminal.
    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
