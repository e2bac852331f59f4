//! Progress bar of a bake or of other work, shown on a terminal only.

use crate::run::Bake;
use indicatif::{HumanCount, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::io::IsTerminal;

/// Progress bar on stderr, hidden where stderr is no terminal.
pub(super) struct ProgressDisplay {
    bar: ProgressBar,
}

impl ProgressDisplay {
    /// Makes the bar of a bake; it has no end if the bake runs to a tolerance.
    ///
    /// The bar counts without being displayed if it is not `shown`.
    pub(super) fn new(bake: &Bake, shown: bool) -> Self {
        let bar = ProgressBar::no_length();
        let template = match bake.all_rays() {
            Some(rays) => {
                bar.set_length(rays);
                "{bar:40} {human_pos}/{human_len} rays, {rate}, {eta} left"
            }
            None => "{spinner} {human_pos} rays, {rate}",
        };
        if !shown || !std::io::stderr().is_terminal() {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.with_key("rate", rate));
        }
        ProgressDisplay { bar }
    }

    /// Makes a bar that counts steps, such as bakes, and names the work that they belong to.
    pub(super) fn of_steps() -> Self {
        let bar = ProgressBar::no_length();
        if !std::io::stderr().is_terminal() {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} {msg}") {
            bar.set_style(style);
        }
        ProgressDisplay { bar }
    }

    /// Displays that the work `name` begins, which has `all` steps.
    pub(super) fn begin(&self, name: &str, all: u64) {
        self.bar.set_length(all);
        self.bar.set_position(0);
        self.bar.set_message(name.to_owned());
    }

    /// Displays that the bake `name` begins, after `done` of `all` bakes.
    pub(super) fn step(&self, name: &str, done: usize, all: usize) {
        self.bar.set_length(all as u64);
        self.bar.set_position(done as u64);
        self.bar.set_message(name.to_owned());
    }

    /// Adds rays or steps to the count; may be called from any thread.
    pub(super) fn advance(&self, rays: u64) {
        self.bar.inc(rays);
    }

    /// Removes the bar from the terminal.
    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Writes the rays a second as a whole number.
fn rate(state: &ProgressState, out: &mut dyn std::fmt::Write) {
    let _ = write!(out, "{}/s", HumanCount(state.per_sec() as u64));
}
