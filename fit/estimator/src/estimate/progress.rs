//! The progress of an estimate, and the flag that stops it.

use std::sync::atomic::{AtomicBool, Ordering};

/// Part of the work that is done: `done` pieces `of` all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Step {
    /// Photographs measured. Several threads report them, in any order.
    Photographs {
        /// Number of photographs measured.
        done: usize,
        /// Number of all photographs.
        of: usize,
    },
    /// Azimuths tried.
    Azimuths {
        /// Number of azimuths tried.
        done: usize,
        /// Number of all azimuths.
        of: usize,
    },
    /// Candidates fitted, by several threads. Each is fitted twice: roughly, then to the end.
    Candidates {
        /// Number of fits done.
        done: usize,
        /// Number of all fits.
        of: usize,
    },
    /// Terms chosen. The bounds come next.
    Chosen,
    /// Suspects tried, where the fit is not good.
    Suspects {
        /// Number of suspects tried.
        done: usize,
        /// Number of all suspects.
        of: usize,
    },
    /// Randomisations of the samples estimated.
    Randomisations {
        /// Number of randomisations done.
        done: usize,
        /// Number of all randomisations.
        of: usize,
    },
}

impl Step {
    /// Returns the step in words: its pieces, the number of those done, and the number of all.
    ///
    /// [`Step::Chosen`] has no pieces.
    pub fn words(self) -> Option<(&'static str, usize, usize)> {
        match self {
            Step::Photographs { done, of } => Some(("photographs measured", done, of)),
            Step::Azimuths { done, of } => Some(("azimuths tried", done, of)),
            Step::Candidates { done, of } => Some(("fits of models", done, of)),
            Step::Chosen => None,
            Step::Suspects { done, of } => Some(("suspects tried", done, of)),
            Step::Randomisations { done, of } => Some(("randomisations", done, of)),
        }
    }
}

/// Error of an estimate that its caller stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Callback for the progress of an estimate, and the flag that stops it.
#[derive(Clone, Copy, Default)]
pub struct Progress<'a> {
    /// Function that is called after each step, from any thread.
    pub report: Option<&'a (dyn Fn(Step) + Sync)>,
    /// Flag that stops the estimate. The estimate ends after the step during which the flag is set.
    pub cancel: Option<&'a AtomicBool>,
}

impl Progress<'_> {
    /// Progress without a callback and without a flag.
    pub const SILENT: Progress<'static> = Progress {
        report: None,
        cancel: None,
    };

    /// Reports that a step is done.
    ///
    /// # Errors
    /// Returns `Cancelled` if the flag is set.
    pub fn done(&self, step: Step) -> Result<(), Cancelled> {
        if let Some(report) = self.report {
            report(step);
        }
        match self.cancel {
            Some(flag) if flag.load(Ordering::Relaxed) => Err(Cancelled),
            _ => Ok(()),
        }
    }
}
