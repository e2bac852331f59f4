//! Progress of a bake: it is told of the rays done, and says whether to go on.

use std::sync::atomic::{AtomicBool, Ordering};

/// Caller's side of a long bake.
#[derive(Clone, Copy)]
pub struct Progress<'a> {
    told: &'a (dyn Fn(u64) + Sync),
    stop: Option<&'a AtomicBool>,
}

impl Progress<'static> {
    /// Makes a progress that is told nothing and never stops the bake.
    pub fn none() -> Self {
        Progress::new(&|_| ())
    }
}

impl<'a> Progress<'a> {
    /// Makes a progress that calls `told` with the number of rays done since its last call.
    ///
    /// The call may come from any thread.
    pub fn new(told: &'a (dyn Fn(u64) + Sync)) -> Self {
        Progress { told, stop: None }
    }

    /// Ends the bake with [`crate::Error::Stopped`] soon after `stop` is set.
    ///
    /// Any thread may set it.
    pub fn stopped_by(self, stop: &'a AtomicBool) -> Self {
        let stop = Some(stop);
        Progress { stop, ..self }
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
