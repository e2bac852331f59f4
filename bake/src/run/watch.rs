//! Watch over a bake: it is told the progress, and says whether to go on.

use std::sync::atomic::{AtomicBool, Ordering};

/// Caller's side of a long bake.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    told: &'a (dyn Fn(u64) + Sync),
    stop: Option<&'a AtomicBool>,
}

impl Watch<'static> {
    /// Makes a watch that is told nothing and never stops the bake.
    pub fn none() -> Self {
        Watch::new(&|_| ())
    }
}

impl<'a> Watch<'a> {
    /// Makes a watch that calls `told` with the number of rays done since its last call.
    ///
    /// The call may come from any thread.
    pub fn new(told: &'a (dyn Fn(u64) + Sync)) -> Self {
        Watch { told, stop: None }
    }

    /// Ends the bake with [`crate::Error::Stopped`] soon after `stop` is set.
    ///
    /// Any thread may set it.
    pub fn stopped_by(self, stop: &'a AtomicBool) -> Self {
        let stop = Some(stop);
        Watch { stop, ..self }
    }

    /// Tells the caller that so many more rays are done.
    pub(crate) fn tell(&self, rays: u64) {
        (self.told)(rays);
    }

    /// Returns whether the bake is to end.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed))
    }
}
