//! Program that calls a verb in its own process.

use std::sync::atomic::AtomicBool;

/// Caller of a bake: it is told the progress, and may stop the bake.
#[derive(Clone, Copy)]
pub struct Caller<'a> {
    /// Function that is told how many rays are done, and how many there are in all; `None` if the
    /// bake runs to a tolerance.
    ///
    /// The call may come from any thread.
    pub told: &'a (dyn Fn(u64, Option<u64>) + Sync),
    /// Flag that stops the bake.
    pub stop: &'a AtomicBool,
}
