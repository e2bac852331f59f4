//! Limits that a process sets on itself.

use rustix::process::{Resource, Rlimit, Signal, getrlimit, setrlimit};

/// Signal that ends a process that has used up its time (SIGXCPU).
pub(crate) const OUT_OF_TIME: i32 = Signal::XCPU.as_raw();

/// Limits this process to `bytes` of address space and `seconds` of the processor since its start.
///
/// Limits can be raised again, up to those of [`cap`]. If the system refuses, the process goes on
/// without them.
pub(crate) fn set(bytes: u64, seconds: u64) {
    limit(Resource::As, bytes, None);
    limit(Resource::Cpu, seconds, None);
}

/// Returns the greatest length of a file that this process may write, bytes; `None` without a
/// limit.
pub(crate) fn longest_file() -> Option<u64> {
    getrlimit(Resource::Fsize).current
}

/// Limits this process for the rest of its life, and forbids it a core file.
///
/// Returns whether the system took all limits.
pub(crate) fn cap(bytes: u64, seconds: u64) -> bool {
    let memory = limit(Resource::As, bytes, Some(bytes));
    // The soft limit of the processor's time sends a signal that can be told from others.
    let time = limit(Resource::Cpu, seconds, Some(seconds + 1));
    let core = limit(Resource::Core, 0, Some(0));
    memory && time && core
}

/// Sets a soft limit, and a hard one if it is given, no higher than the hard limit that there is.
///
/// Returns whether the system took it.
fn limit(resource: Resource, soft: u64, hard: Option<u64>) -> bool {
    let most = getrlimit(resource).maximum;
    let below = |wanted: u64| Some(most.map_or(wanted, |most| wanted.min(most)));
    let limit = Rlimit {
        current: below(soft),
        maximum: hard.map_or(most, below),
    };
    setrlimit(resource, limit).is_ok()
}
