//! Limits that a process sets itself: calls into the C library that every program is linked with.

#![allow(unsafe_code, reason = "calls into the C library")]

use std::ffi::c_int;

// Numbers of Linux on x86-64 and most others (asm-generic/resource.h).
const CPU: c_int = 0;
const CORE: c_int = 4;
const ADDRESS_SPACE: c_int = 9;

/// Signal of a process that has used up its time (SIGXCPU).
pub(crate) const OUT_OF_TIME: i32 = 24;

/// The limit in force, and the one up to which it may be raised.
#[repr(C)]
struct Limit {
    current: u64,
    most: u64,
}

unsafe extern "C" {
    fn getrlimit(resource: c_int, limit: *mut Limit) -> c_int;
    fn setrlimit(resource: c_int, limit: *const Limit) -> c_int;
}

/// Limits this process to so many bytes of address space and seconds of the processor, since its start; it leaves no
/// core file. A system that refuses goes on without.
pub(crate) fn set(bytes: u64, seconds: u64) {
    for (resource, wanted) in [(ADDRESS_SPACE, bytes), (CPU, seconds), (CORE, 0)] {
        let mut limit = Limit {
            current: 0,
            most: 0,
        };
        // SAFETY: the library writes one limit, which lives until the end of the call.
        if unsafe { getrlimit(resource, &raw mut limit) } == 0 {
            limit.current = wanted.min(limit.most);
            // SAFETY: it reads that limit.
            let _ = unsafe { setrlimit(resource, &raw const limit) };
        }
    }
}
