//! Tests of a bake that is stopped by a signal or a full disk.
//!
//! It leaves the old table whole, and goes on to the same bytes.

use crate::program::{Folder, said};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Returns the line of a bake of rays that is saved as often as possible.
fn trace(file: &str, options: &str) -> String {
    format!("trace full-cube.obj -o {file} --method rays --bins 64 --save-every 0 {options}")
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
#[ignore = "a minute: `make test-kills` runs it"]
fn stopped_at_75_random_moments_it_ends_with_the_same_bytes() {
    let folder = Folder::with(&["full-cube"]);
    let mut numbers = Numbers(1);
    let (mut kills, mut went_on, mut completed) = (0, 0, 0);
    for options in [
        "--rays 30000000 --incidence 0:60:20",
        "--tolerance 0.004 --incidence 0:60:20",
        "--rays 100000 --incidence 30,45 --refractive-index 1.49 --front trapped",
    ] {
        let begun = Instant::now();
        folder.good(&trace("whole.h5", options));
        let time = begun.elapsed();
        let whole = folder.read("whole.h5");
        let resumes = folder.file("table.h5.resume");
        let again = trace("table.h5", &format!("{options} --resume"));
        folder.write("table.h5", "old");
        let complete = || {
            assert!(folder.read("table.h5") == whole, "{options}");
            assert!(!resumes.exists(), "nothing is left to go on with");
            folder.write("table.h5", "old");
        };
        let mut here_kills = 0;
        while here_kills < 25 {
            went_on += usize::from(resumes.exists());
            let mut command = folder.command(&again);
            let mut child = command.stdout(Stdio::null()).spawn().expect("bake runs");
            let delay = time.as_micros() as u64 / 10;
            std::thread::sleep(Duration::from_micros(numbers.below(delay)));
            if child.try_wait().expect("it can be asked").is_some() {
                complete();
                completed += 1;
                continue;
            }
            stop(&mut child, ["INT", "TERM", "KILL"][here_kills % 3]);
            // The signal may have come between the last write and the end of the process.
            let now = folder.read("table.h5");
            assert!(now == b"old" || now == whole, "half a table");
            folder.write("table.h5", "old");
            here_kills += 1;
        }
        kills += here_kills;
        folder.good(&again);
        complete();
    }
    println!("{kills} kills, {went_on} times from a save, {completed} times done in between");
    assert_eq!(kills, 75);
    assert!(went_on > 10, "a test of going on, not of beginning again");
}

#[test]
fn a_full_disk_leaves_the_old_table() {
    let folder = Folder::with(&["full-cube"]);
    folder.write("table.h5", "old");
    // A shell can limit files to 1 kB without root. The signal that the limit sends is ignored.
    let output = Command::new("sh")
        .current_dir(folder.path())
        .args(["-c", "trap '' XFSZ; ulimit -f 2; exec \"$@\"", "sh"])
        .arg(env!("CARGO_BIN_EXE_bake"))
        .args("trace full-cube.obj -o table.h5 --method rays --rays 10000".split(' '))
        .output()
        .expect("a shell");
    let message = said(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("table.h5: cannot be written"), "{message}");
    assert_eq!(folder.read("table.h5"), b"old");
    assert_eq!(folder.names(), ["full-cube.obj", "table.h5"]);
}

#[test]
fn what_was_saved_of_another_bake_is_refused() {
    let folder = Folder::with(&["full-cube"]);
    folder.good(&trace("saved.h5", "--rays 50000"));
    let saved = || folder.write("table.h5.resume", folder.read("saved.h5"));
    let mut refused = 0;
    for options in [
        "--rays 50000 --seed 2",
        "--rays 50000 --incidence 0:40:5",
        "--rays 49999 --seed 1",
        "--tolerance 0.1 --seed 1",
    ] {
        saved();
        let line = trace("table.h5", &format!("{options} --resume"));
        folder.refused(&line, 2, "the bake that was saved is another one");
        assert!(folder.file("table.h5.resume").exists());
        refused += 1;
    }
    assert_eq!(refused, 4);
    // A bake with more rays and otherwise equal options goes on from the save.
    folder.good(&trace("whole.h5", "--rays 80000"));
    folder.good(&trace("table.h5", "--rays 80000 --resume"));
    assert!(folder.read("table.h5") == folder.read("whole.h5"));
    // Without --resume the bake begins anew, and a message says so.
    saved();
    let message = said(&folder.run(&trace("table.h5", "--rays 80000")));
    assert!(message.contains("--resume would go on with"), "{message}");
    assert!(folder.read("table.h5") == folder.read("whole.h5"));
}
