//! Tests of a bake that is stopped by a signal or a full disk.
//!
//! It leaves the old table whole, and goes on to the same bytes.

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Returns the command of a bake of rays that is saved as often as possible.
fn command(folder: &Path, file: &str, options: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bake"));
    let common = [
        "trace",
        "cell.obj",
        "-o",
        file,
        "--method",
        "rays",
        "--bins",
        "64",
        "--save-every",
        "0",
    ];
    command
        .current_dir(folder)
        .args(common)
        .args(options)
        .stdout(Stdio::null());
    command
}

fn design(folder: &Path) {
    let made = Command::new(env!("CARGO_BIN_EXE_bake"))
        .current_dir(folder)
        .args(["design", "full-cube", "-o", "cell.obj"])
        .status()
        .expect("bake runs");
    assert!(made.success());
}

fn done(output: &Output) {
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

/// Returns numbers below `n` that are equal in all runs (splitmix64).
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) % n
    }
}

fn stop(child: &mut Child, signal: &str) {
    let sent = Command::new("kill")
        .args(["-s", signal, &child.id().to_string()])
        .status();
    assert!(sent.expect("kill runs").success());
    child.wait().expect("it ends");
}

#[test]
fn stopped_at_75_random_moments_it_ends_with_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    design(here);
    let mut numbers = Numbers(1);
    let (mut kills, mut went_on, mut completed) = (0, 0, 0);
    for options in [
        &["--rays", "30000000", "--incidence", "0:60:20"][..],
        &["--tolerance", "0.004", "--incidence", "0:60:20"],
        &[
            "--rays",
            "100000",
            "--incidence",
            "30,45",
            "--refractive-index",
            "1.49",
            "--front",
            "trapped",
        ],
    ] {
        let begun = Instant::now();
        done(
            &command(here, "whole.h5", options)
                .output()
                .expect("bake runs"),
        );
        let time = begun.elapsed();
        let whole = std::fs::read(here.join("whole.h5")).expect("a table");
        let table = here.join("table.h5");
        let resumes = here.join("table.h5.resume");
        let again = [options, &["--resume"]].concat();
        std::fs::write(&table, "old").expect("writes");
        let complete = || {
            assert!(
                std::fs::read(&table).expect("a table") == whole,
                "{options:?}"
            );
            assert!(!resumes.exists(), "nothing is left to go on with");
            std::fs::write(&table, "old").expect("writes");
        };
        let mut here_kills = 0;
        while here_kills < 25 {
            went_on += usize::from(resumes.exists());
            let mut child = command(here, "table.h5", &again)
                .spawn()
                .expect("bake runs");
            let delay = time.as_micros() as u64 / 10;
            std::thread::sleep(Duration::from_micros(numbers.below(delay)));
            if child.try_wait().expect("it can be asked").is_some() {
                complete();
                completed += 1;
                continue;
            }
            stop(&mut child, ["INT", "TERM", "KILL"][here_kills % 3]);
            // The signal may have come between the last write and the end of the process.
            let now = std::fs::read(&table).expect("a table");
            assert!(now == b"old" || now == whole, "half a table");
            std::fs::write(&table, "old").expect("writes");
            here_kills += 1;
        }
        kills += here_kills;
        done(
            &command(here, "table.h5", &again)
                .output()
                .expect("bake runs"),
        );
        complete();
    }
    println!("{kills} kills, {went_on} times from a save, {completed} times done in between");
    assert_eq!(kills, 75);
    assert!(went_on > 10, "a test of going on, not of beginning again");
}

/// Returns the names of everything in a folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("lists").flatten();
    let mut names: Vec<String> = entries
        .map(|e| e.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[test]
fn a_full_disk_leaves_the_old_table() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    design(here);
    std::fs::write(here.join("table.h5"), "old").expect("writes");
    // A shell can limit files to 1 kB without root. The signal that the limit sends is ignored.
    let output = Command::new("sh")
        .current_dir(here)
        .args(["-c", "trap '' XFSZ; ulimit -f 2; exec \"$@\"", "sh"])
        .arg(env!("CARGO_BIN_EXE_bake"))
        .args([
            "trace", "cell.obj", "-o", "table.h5", "--method", "rays", "--rays", "10000",
        ])
        .output()
        .expect("a shell");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("table.h5: cannot be written"), "{message}");
    assert_eq!(
        std::fs::read(here.join("table.h5")).expect("a table"),
        b"old"
    );
    assert_eq!(names(here), ["cell.obj", "table.h5"]);
}

#[test]
fn what_was_saved_of_another_bake_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    design(here);
    done(
        &command(here, "saved.h5", &["--rays", "50000"])
            .output()
            .expect("bake runs"),
    );
    let mut refused = 0;
    for options in [
        ["--rays", "50000", "--seed", "2"],
        ["--rays", "50000", "--incidence", "0:40:5"],
        ["--rays", "49999", "--seed", "1"],
        ["--tolerance", "0.1", "--seed", "1"],
    ] {
        std::fs::copy(here.join("saved.h5"), here.join("table.h5.resume")).expect("copies");
        let output = command(here, "table.h5", &[&options[..], &["--resume"]].concat()).output();
        let output = output.expect("bake runs");
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{options:?}: {message}");
        assert!(
            message.contains("the bake that was saved is another one"),
            "{message}"
        );
        assert!(here.join("table.h5.resume").exists());
        refused += 1;
    }
    assert_eq!(refused, 4);
    // A bake with more rays and otherwise equal options goes on from the save.
    let more = ["--rays", "80000"];
    done(
        &command(here, "whole.h5", &more)
            .output()
            .expect("bake runs"),
    );
    done(
        &command(here, "table.h5", &[&more[..], &["--resume"]].concat())
            .output()
            .expect("bake runs"),
    );
    let bytes = |file: &str| std::fs::read(here.join(file)).expect("a table");
    assert!(bytes("table.h5") == bytes("whole.h5"));
    // Without --resume the bake begins anew, and a message says so.
    std::fs::copy(here.join("saved.h5"), here.join("table.h5.resume")).expect("copies");
    let output = command(here, "table.h5", &more)
        .output()
        .expect("bake runs");
    assert!(String::from_utf8_lossy(&output.stderr).contains("--resume would go on with"));
    assert!(bytes("table.h5") == bytes("whole.h5"));
}
