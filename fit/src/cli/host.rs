//! The side that a verb reports its progress to: a terminal, or another program.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::cli::failure::Failure;
use crate::cli::progress::Bar;
use estimator::estimate::Step;

/// Program that calls a verb in its own process.
#[derive(Clone, Copy)]
pub struct Caller<'a> {
    /// Function that is told which pieces are done, how many are done, and how many there are.
    ///
    /// The call may come from any thread.
    pub told: &'a (dyn Fn(&str, u64, u64) + Sync),
    /// Flag that stops the work. The work ends after the piece during which the flag is set.
    pub stop: &'a AtomicBool,
}

impl Caller<'_> {
    /// Tells of a step of an estimate.
    pub(super) fn show(&self, step: Step) {
        if let Some((what, done, of)) = step.words() {
            (self.told)(what, done as u64, of as u64);
        }
    }
}

/// Side that a study reports to.
#[derive(Clone, Copy)]
pub(super) enum Host<'a> {
    /// Terminal, with a bar.
    Terminal,
    /// Another program.
    Caller(Caller<'a>),
}

impl Host<'_> {
    /// Runs `all`, which gets a function to call after each of the campaigns.
    ///
    /// # Errors
    /// Returns [`Failure::Stopped`] if the caller's flag was set meanwhile.
    pub(super) fn watch<T>(
        &self,
        campaigns: u64,
        all: impl FnOnce(&(dyn Fn() -> bool + Sync)) -> T,
    ) -> Result<T, Failure> {
        match self {
            Host::Terminal => {
                let progress = Bar::of(campaigns);
                let made = all(&|| {
                    progress.step();
                    true
                });
                progress.done();
                Ok(made)
            }
            Host::Caller(Caller { told, stop }) => {
                let done = AtomicU64::new(0);
                let made = all(&|| {
                    told(
                        "campaigns",
                        1 + done.fetch_add(1, Ordering::Relaxed),
                        campaigns,
                    );
                    !stop.load(Ordering::Relaxed)
                });
                match stop.load(Ordering::Relaxed) {
                    true => Err(Failure::Stopped),
                    false => Ok(made),
                }
            }
        }
    }
}
