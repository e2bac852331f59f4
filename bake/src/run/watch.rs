//! Who watches a bake: told how far it is, and asked whether to go on.

use std::sync::atomic::{AtomicBool, Ordering};

/// The caller's side of a long bake.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    told: &'a (dyn Fn(u64) + Sync),
    stop: Option<&'a AtomicBool>,
}

impl Watch<'static> {
    /// Nobody watches.
    pub fn none() -> Self {
        Watch::new(&|_| ())
    }
}

impl<'a> Watch<'a> {
    /// `told` is called, from any thread, with the number of rays that were done since its last
    /// call.
    pub fn new(told: &'a (dyn Fn(u64) + Sync)) -> Self {
        Watch { told, stop: None }
    }

    /// Ends the bake with [`crate::run::error::RunError::Stopped`] soon after `stop` was set, from
    /// any thread.
    pub fn stopped_by(self, stop: &'a AtomicBool) -> Self {
        let stop = Some(stop);
        Watch { stop, ..self }
    }

    /// Tells of rays that are done.
    pub(crate) fn tell(&self, rays: u64) {
        (self.told)(rays);
    }

    /// Whether the bake is to end.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed))
    }
}
