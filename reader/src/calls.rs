//! Descriptors and calls: a process that has the three standard streams alone, and a thread that
//! can ask the system for memory and the clock, read standard input and write standard output.
//!
//! The list is what the library, the allocator and the runtime were seen to call while they read
//! all kinds of tables and damaged ones. Any other call fails with "not permitted". It does not end
//! the process: another C library may make a harmless call that was not seen here.

use std::collections::BTreeMap;

use seccompiler::{
    BpfProgram, SeccompAction, SeccompCmpArgLen, SeccompCmpOp, SeccompCondition, SeccompFilter,
    SeccompRule, apply_filter,
};

/// Calls that are allowed whatever their arguments are.
const ALLOWED: &[i64] = &[
    // Memory.
    libc::SYS_brk,
    libc::SYS_munmap,
    libc::SYS_mremap,
    libc::SYS_madvise,
    // The clock, and a seed for hash tables.
    libc::SYS_clock_gettime,
    libc::SYS_gettimeofday,
    libc::SYS_getrandom,
    // Locks, signals and the end.
    libc::SYS_futex,
    libc::SYS_sched_yield,
    libc::SYS_restart_syscall,
    libc::SYS_rt_sigprocmask,
    libc::SYS_rt_sigreturn,
    libc::SYS_sigaltstack,
    libc::SYS_exit,
    libc::SYS_exit_group,
];

/// Descriptor that may be read: standard input.
const INPUT: u64 = 0;
/// Descriptors that may be written: standard output and standard error.
const OUTPUTS: [u64; 2] = [1, 2];

/// Closes all files but the standard streams, those that the caller left open; returns whether that
/// holds. Rust's own files must not be used any more.
#[allow(unsafe_code, reason = "a call into the system that Rust does not wrap")]
pub(crate) fn close_files() -> bool {
    // SAFETY: the call takes numbers. Nothing in this process owns a file from here on.
    unsafe { libc::syscall(libc::SYS_close_range, 3, libc::c_uint::MAX, 0) == 0 }
}

/// Gives up all calls but those of this file for the thread; returns whether that holds.
///
/// Sets `no_new_privs` too.
pub(crate) fn give_up() -> bool {
    program().is_ok_and(|program| apply_filter(&program).is_ok())
}

/// Returns the filter.
fn program() -> Result<BpfProgram, seccompiler::BackendError> {
    let equal = |argument, value| {
        SeccompCondition::new(argument, SeccompCmpArgLen::Dword, SeccompCmpOp::Eq, value)
            .and_then(|condition| SeccompRule::new(vec![condition]))
    };
    // Memory may be mapped if no code can be run from it, and if no file lies behind it: through a
    // file that the caller has open, content would leave this process.
    let condition = |argument, value, bits: i32| {
        let how = SeccompCmpOp::MaskedEq(bits as u64);
        SeccompCondition::new(argument, SeccompCmpArgLen::Dword, how, value)
    };
    let data = || condition(2, 0, libc::PROT_EXEC);
    let own = || condition(3, libc::MAP_ANONYMOUS as u64, libc::MAP_ANONYMOUS);
    let mut rules: BTreeMap<i64, Vec<SeccompRule>> =
        ALLOWED.iter().map(|&call| (call, Vec::new())).collect();
    let mapped = SeccompRule::new(vec![data()?, own()?])?;
    rules.insert(libc::SYS_mmap, vec![mapped]);
    rules.insert(libc::SYS_mprotect, vec![SeccompRule::new(vec![data()?])?]);
    rules.insert(libc::SYS_read, vec![equal(0, INPUT)?]);
    let outputs = OUTPUTS.map(|output| equal(0, output));
    rules.insert(
        libc::SYS_write,
        outputs.into_iter().collect::<Result<_, _>>()?,
    );
    // The process changes its own soft limits, which stay below the hard ones.
    rules.insert(libc::SYS_prlimit64, vec![equal(0, 0)?]);
    SeccompFilter::new(
        rules,
        SeccompAction::Errno(libc::EPERM as u32),
        SeccompAction::Allow,
        std::env::consts::ARCH.try_into()?,
    )?
    .try_into()
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::io::ErrorKind;
    use std::net::UdpSocket;
    use std::thread;

    use super::*;
    use crate::tries::map;

    /// The filter alone, in a thread of its own: the layer above Landlock refuses files too, and
    /// a file that is open already cannot be mapped.
    #[test]
    fn seccomp_alone_refuses_files_sockets_and_maps() {
        let program = std::env::current_exe().expect("a test is a file");
        let open = File::open(&program).expect("it can be read before");
        map(&open).expect("it can be mapped before");
        UdpSocket::bind("127.0.0.1:0").expect("it can be bound before");
        let tried = thread::spawn(move || {
            if !give_up() {
                return None;
            }
            let file = File::open(program).map(drop);
            let socket = UdpSocket::bind("127.0.0.1:0").map(drop);
            // Memory of this size is mapped anew.
            let memory = vec![1_u8; 1 << 26];
            let tried = [file, socket, map(&open)].map(|tried| tried.map_err(|e| e.kind()));
            Some((tried, memory.len()))
        })
        .join()
        .expect("the thread ends");
        match tried {
            Some((tried, _)) => assert_eq!(tried, [Err(ErrorKind::PermissionDenied); 3]),
            None => println!("this kernel has no seccomp: 0 tries"),
        }
    }
}
