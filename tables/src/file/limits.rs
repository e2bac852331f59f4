//! Limits that a process sets on itself.

use rustix::process::{Resource, Rlimit, Signal, getrlimit, setrlimit};

/// Signal that ends a process that has used up its time (SIGXCPU).
pub(crate) const OUT_OF_TIME: i32 = Signal::XCPU.as_raw();

/// Limits this process to `bytes` of address space and `seconds` of the processor since its start.
///
/// It will leave no core file. If the system refuses, the process goes on without limits.
pub(crate) fn set(bytes: u64, seconds: u64) {
    for (resource, wanted) in [
        (Resource::As, bytes),
        (Resource::Cpu, seconds),
        (Resource::Core, 0),
    ] {
        let maximum = getrlimit(resource).maximum;
        let current = Some(maximum.map_or(wanted, |most| wanted.min(most)));
        let _ = setrlimit(resource, Rlimit { current, maximum });
    }
}
