//! Progress of renders, pages and comparisons.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Step of long work: the pieces of one kind of work that are done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RenderStep {
    /// Pieces of the work, in words.
    pub what: &'static str,
    /// Number of pieces that are done.
    pub done: usize,
    /// Number of all pieces.
    pub of: usize,
}

/// Callback for the progress, called from any thread.
pub type RenderProgress<'a> = &'a (dyn Fn(RenderStep) + Sync);

/// Callback that does nothing.
pub const SILENT: RenderProgress<'static> = &|_| ();

/// Counter of the pieces of one kind of work.
pub(crate) struct Pieces<'a> {
    progress: RenderProgress<'a>,
    what: &'static str,
    of: usize,
    done: AtomicUsize,
}

impl<'a> Pieces<'a> {
    /// Returns a counter of `of` pieces, and reports that none of them is done.
    pub(crate) fn new(progress: RenderProgress<'a>, what: &'static str, of: usize) -> Pieces<'a> {
        progress(RenderStep { what, done: 0, of });
        Pieces {
            progress,
            what,
            of,
            done: AtomicUsize::new(0),
        }
    }

    /// Counts a piece as done and reports it.
    pub(crate) fn one(&self) {
        let done = 1 + self.done.fetch_add(1, Ordering::Relaxed);
        (self.progress)(RenderStep {
            what: self.what,
            done,
            of: self.of,
        });
    }
}
