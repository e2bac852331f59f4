//! The progress bar: on a terminal only.

use crate::plan::{Effort, Plan};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;

/// A bar on stderr that counts rays; silent where stderr is no terminal.
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar as long as the plan's rays; without an end where the plan runs to a tolerance.
    pub fn new(plan: &Plan) -> Self {
        let (incidences, azimuths) = plan.axes.shape();
        let (bar, template) = match plan.effort {
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
        if !std::io::stderr().is_terminal() {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        Progress { bar }
    }

    /// Counts rays; may be called from any thread.
    pub fn advance(&self, rays: u64) {
        self.bar.inc(rays);
    }

    /// Takes the bar off the terminal.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
