//! Landlock: a thread that can open no file and, from Linux 6.7 on, no socket.

use landlock::{
    ABI, Access, AccessFs, AccessNet, CompatLevel, Compatible, Ruleset, RulesetAttr, RulesetStatus,
    Scope,
};

/// Newest interface of Landlock whose rights are given up; an older kernel gives up what it knows.
const NEWEST: ABI = ABI::V6;

/// Gives up every right to files for this thread and what it starts; returns whether it holds.
///
/// Sets `no_new_privs` too.
pub(crate) fn give_up() -> bool {
    let enforced = Ruleset::default()
        .set_compatibility(CompatLevel::BestEffort)
        .handle_access(AccessFs::from_all(NEWEST))
        .and_then(|rules| rules.handle_access(AccessNet::from_all(NEWEST)))
        .and_then(|rules| rules.scope(Scope::from_all(NEWEST)))
        .and_then(Ruleset::create)
        .and_then(|rules| rules.restrict_self());
    enforced.is_ok_and(|status| status.no_new_privs && status.ruleset != RulesetStatus::NotEnforced)
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::io::ErrorKind;
    use std::thread;

    use super::*;

    /// Landlock alone, in a thread of its own: the layer below seccomp refuses files too.
    #[test]
    fn landlock_alone_refuses_files() {
        let program = std::env::current_exe().expect("a test is a file");
        File::open(&program).expect("it can be read before");
        let tried = thread::spawn(move || {
            if !give_up() {
                return None;
            }
            let folder = std::fs::read_dir("/").map(|_| ());
            let file = File::open(program).map(|_| ());
            let made = File::create("/tmp/airr-reader-test").map(|_| ());
            Some([folder, file, made].map(|tried| tried.map_err(|error| error.kind())))
        })
        .join()
        .expect("the thread ends");
        match tried {
            Some(tried) => assert_eq!(tried, [Err(ErrorKind::PermissionDenied); 3]),
            None => println!("this kernel has no Landlock: 0 tries"),
        }
    }
}
