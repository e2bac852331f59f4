//! Partial files and folders: their names, and the removal of those that a killed run left behind.
//!
//! A name holds the start of the machine, the space of processes and the process, so that a later
//! run can prove that its writer is dead: no other machine and no container shares the first two.

use std::fs;
use std::io;
use std::path::Path;
use std::sync::OnceLock;

use rustix::io::Errno;
use rustix::process::{Pid, test_kill_process};
use sha2::{Digest, Sha256};

use crate::file::content::hex;
use crate::file::output::unnamed;

use tempfile::TempDir;

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

/// Makes a partial folder within `parent`, for an output that is a folder. It is removed when it is
/// dropped, unless it was renamed.
///
/// Partial files and folders that killed runs of this machine left in `parent` are removed.
///
/// # Errors
/// Returns the error of the system if `parent` takes no folder.
pub fn scratch_folder(parent: &Path) -> io::Result<TempDir> {
    sweep(parent);
    let prefix = prefix();
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(SUFFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The rights of any new folder (the umask applies), for it is renamed to the output.
        builder.permissions(fs::Permissions::from_mode(0o777));
    }
    builder.tempdir_in(parent).map_err(unnamed)
}

/// Removes the partial files and folders in a folder whose writers are dead.
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
        if !writer.is_some_and(is_dead) {
            continue;
        }
        // A link is neither a file nor a folder here, and stays.
        let _ = match entry.file_type() {
            Ok(kind) if kind.is_file() => fs::remove_file(entry.path()),
            Ok(kind) if kind.is_dir() => fs::remove_dir_all(entry.path()),
            _ => Ok(()),
        };
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
        let of_dead = |random: &str| {
            folder
                .path()
                .join(format!(".airr-{home}-{dead}-{random}.partial"))
        };
        let (left, link) = (of_dead("folder"), of_dead("link"));
        fs::create_dir(&left).expect("a folder");
        fs::write(left.join("image"), "").expect("a file in it");
        let precious = tempfile::tempdir().expect("a folder elsewhere");
        fs::write(precious.path().join("mine"), "").expect("a file in it");
        std::os::unix::fs::symlink(precious.path(), &link).expect("a link");
        let living = scratch_folder(folder.path()).expect("it sweeps, and makes a folder");
        assert!(!left.exists() && living.path().is_dir());
        assert!(link.is_symlink() && precious.path().join("mine").exists());
        for (name, stays) in &names {
            assert_eq!(folder.path().join(name).exists(), *stays, "{name}");
        }
        println!("{} names", names.len() + 3);
    }
}
