//! Progress of a render.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Part of a render that is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    /// Pieces of the work, in words.
    pub what: &'static str,
    /// Number of pieces that are done.
    pub done: usize,
    /// Number of all pieces.
    pub of: usize,
}

/// Callback for the progress of a render, called from any thread.
pub type Watch<'a> = &'a (dyn Fn(Part) + Sync);

/// Callback that does nothing.
pub const UNWATCHED: Watch<'static> = &|_| ();

/// Counter of the pieces of one kind of work.
pub(crate) struct Pieces<'a> {
    watch: Watch<'a>,
    what: &'static str,
    of: usize,
    done: AtomicUsize,
}

impl<'a> Pieces<'a> {
    /// Returns a counter of `of` pieces, none of them done.
    pub(crate) fn new(watch: Watch<'a>, what: &'static str, of: usize) -> Pieces<'a> {
        Pieces {
            watch,
            what,
            of,
            done: AtomicUsize::new(0),
        }
    }

    /// Counts a piece as done and reports it.
    pub(crate) fn one(&self) {
        let done = 1 + self.done.fetch_add(1, Ordering::Relaxed);
        (self.watch)(Part {
            what: self.what,
            done,
            of: self.of,
        });
    }
}
