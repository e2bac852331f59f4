//! Limits that a process sets on itself.

use rustix::process::{Resource, Rlimit, Signal, getrlimit, setrlimit};

/// Signal that ends a process that has used up its time (SIGXCPU).
pub(crate) const OUT_OF_TIME: i32 = Signal::XCPU.as_raw();

/// Limits this process to `bytes` of address space and `seconds` of the processor since its start.
///
/// Limits can be raised again, up to those of [`cap`]. If the system refuses, the process goes on
/// without them.
pub(crate) fn set(bytes: u64, seconds: u64) {
    for (resource, wanted) in [(Resource::As, bytes), (Resource::Cpu, seconds)] {
        let maximum = getrlimit(resource).maximum;
        let current = Some(maximum.map_or(wanted, |most| wanted.min(most)));
        let _ = setrlimit(resource, Rlimit { current, maximum });
    }
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
    // The soft limit of the processor's time sends a signal that can be told from others.
    let limits = [
        (Resource::As, bytes, bytes),
        (Resource::Cpu, seconds, seconds + 1),
        (Resource::Core, 0, 0),
    ];
    limits
        .into_iter()
        .fold(true, |taken, (resource, soft, hard)| {
            let most = getrlimit(resource).maximum;
            let below = |wanted: u64| Some(most.map_or(wanted, |most| wanted.min(most)));
            let limit = Rlimit {
                current: below(soft),
                maximum: below(hard),
            };
            setrlimit(resource, limit).is_ok() && taken
        })
}
