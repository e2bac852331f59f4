//! Who watches an estimate: how far it is, and whether it shall stop.

use std::sync::atomic::{AtomicBool, Ordering};

/// A piece of work that is done; `of` are to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Step {
    /// Photographs measured. Said by several threads, in any order.
    Photographs {
        /// Done.
        done: usize,
        /// In all.
        of: usize,
    },
    /// Azimuths looked at.
    Azimuths {
        /// Done.
        done: usize,
        /// In all.
        of: usize,
    },
    /// Candidates fitted: each at first sight, and once more.
    Candidates {
        /// Done.
        done: usize,
        /// In all.
        of: usize,
    },
    /// The terms are chosen; bounds come next.
    Chosen,
    /// Randomisations of the samples estimated.
    Randomisations {
        /// Done.
        done: usize,
        /// In all.
        of: usize,
    },
}

/// The estimate was cancelled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// What is told of an estimate's progress, and the flag that ends it.
#[derive(Clone, Copy, Default)]
pub struct Watch<'a> {
    /// Called after every step, from any thread.
    pub progress: Option<&'a (dyn Fn(Step) + Sync)>,
    /// Ends the estimate after the step at which it is set.
    pub cancel: Option<&'a AtomicBool>,
}

impl Watch<'_> {
    /// Nobody watches, and nobody cancels.
    pub const NOBODY: Watch<'static> = Watch {
        progress: None,
        cancel: None,
    };

    /// Says that a step is done.
    ///
    /// # Errors
    /// `Cancelled` where the flag is set.
    pub fn done(&self, step: Step) -> Result<(), Cancelled> {
        if let Some(progress) = self.progress {
            progress(step);
        }
        match self.cancel {
            Some(flag) if flag.load(Ordering::Relaxed) => Err(Cancelled),
            _ => Ok(()),
        }
    }
}
