//! All that a process gives up before it reads a stranger's file.

use tables::reader::{Protection, begin};

/// Confines this process for good, for a file of this length in bytes.
///
/// Returns what the system did not give. The process must have one thread.
pub(crate) fn confine(file_bytes: u64) -> Vec<Protection> {
    let limited = begin(file_bytes);
    let (files, calls) = rights();
    let given = [
        (Protection::Limits, limited),
        (Protection::Files, files),
        (Protection::Calls, calls),
    ];
    let lacking = given.into_iter().filter(|(_, given)| !given);
    lacking.map(|(protection, _)| protection).collect()
}

/// Gives up files, those that the caller left open too, then what is left of the system's calls;
/// returns whether each was possible.
#[cfg(target_os = "linux")]
fn rights() -> (bool, bool) {
    use rustix::process::{Resource, Rlimit, setrlimit};

    let none = Rlimit {
        current: Some(0),
        maximum: Some(0),
    };
    let files = crate::files::give_up() & crate::calls::close_files();
    // The process may open no descriptor and start no process. Memory and time are limited already.
    for resource in [Resource::Nofile, Resource::Nproc] {
        let _ = setrlimit(resource, none);
    }
    (files, crate::calls::give_up())
}

/// Does nothing: only Linux has Landlock and seccomp.
#[cfg(not(target_os = "linux"))]
fn rights() -> (bool, bool) {
    (false, false)
}
