//! Partial files: their names, and the removal of those that a killed run left behind.
//!
//! A name holds the start of the machine, the space of processes and the process, so that a later
//! run can prove that its writer is dead: no other machine and no container shares the first two.

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use rustix::io::Errno;
use rustix::process::{Pid, test_kill_process};
use sha2::{Digest, Sha256};

use crate::file::content::hex;

/// Start of the names of partial files.
const PREFIX: &str = ".airr-";
/// End of the names of partial files.
pub(crate) const SUFFIX: &str = ".partial";

/// Returns the start of the names of this process's partial files.
pub(crate) fn prefix() -> String {
    match home() {
        Some(home) => format!("{PREFIX}{home}-{}-", std::process::id()),
        None => PREFIX.to_owned(),
    }
}

/// Returns what tells this run of the machine and this space of processes from all others; `None`
/// where the system does not say.
fn home() -> Option<&'static str> {
    static HOME: OnceLock<Option<String>> = OnceLock::new();
    let home = HOME.get_or_init(|| {
        let boot = fs::read("/proc/sys/kernel/random/boot_id").ok()?;
        let space = fs::read_link("/proc/self/ns/pid").ok()?;
        let mut hash = Sha256::new();
        hash.update(&boot);
        hash.update(space.as_os_str().as_encoded_bytes());
        Some(hex(hash.finalize().as_ref())[..16].to_owned())
    });
    home.as_deref()
}

/// Removes the partial files in a folder whose writers are dead.
pub(crate) fn sweep(folder: &Path) {
    let (Some(home), Ok(entries)) = (home(), fs::read_dir(folder)) else {
        return;
    };
    let start = format!("{PREFIX}{home}-");
    for entry in entries.flatten() {
        let name = entry.file_name();
        let writer = name
            .to_str()
            .and_then(|name| name.strip_prefix(&start))
            .filter(|rest| rest.ends_with(SUFFIX))
            .and_then(|rest| rest.split('-').next()?.parse::<i32>().ok())
            .and_then(Pid::from_raw);
        let is_file = || entry.file_type().is_ok_and(|kind| kind.is_file());
        if writer.is_some_and(is_dead) && is_file() {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Returns whether there is no process of this number, not even one of another user.
fn is_dead(process: Pid) -> bool {
    test_kill_process(process) == Err(Errno::SRCH)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The partial file of a dead process goes; those of a living one, of another machine and of
    /// other programs stay.
    #[test]
    fn only_the_files_of_the_dead_are_removed() {
        let Some(home) = home() else {
            println!("this system names no start of the machine: 0 files");
            return;
        };
        let mut child = std::process::Command::new("true")
            .spawn()
            .expect("true starts");
        let dead = child.id();
        child.wait().expect("it ends");
        let folder = tempfile::tempdir().expect("a folder");
        let alive = std::process::id();
        let names = [
            (format!(".airr-{home}-{dead}-a1b2c3.partial"), false),
            (format!(".airr-{home}-{alive}-a1b2c3.partial"), true),
            (
                format!(".airr-0123456789abcdef-{dead}-a1b2c3.partial"),
                true,
            ),
            (format!(".airr-{home}-{dead}-a1b2c3"), true),
            (format!(".airr-{home}-x-a1b2c3.partial"), true),
            (".airr-abcdef.partial".to_owned(), true),
        ];
        for (name, _) in &names {
            fs::write(folder.path().join(name), "").expect("a file");
        }
        sweep(folder.path());
        for (name, stays) in &names {
            assert_eq!(folder.path().join(name).exists(), *stays, "{name}");
        }
        println!("{} names", names.len());
    }
}
