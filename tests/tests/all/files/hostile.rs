//! Files that were made to do harm. Each must end in one clear error, in little time and memory.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use tests::files::{argument, bake_table_with};
use tests::program::{python, run_by};

/// Greatest memory of any process of a command, bytes.
const MOST_BYTES: u64 = 500_000_000;

/// Greatest time of a command, seconds.
///
/// This limit only stops work without end. The aim is 2 s, but the machine may be busy. So the time
/// is printed, and the test does not assert the aim.
const MOST_SECONDS: f64 = 30.0;

/// Python program that runs its arguments as a command.
///
/// After the output of the command it prints the greatest memory of any of its processes, KiB.
const MEASURE: &str = "import resource, subprocess, sys\n\
    code = subprocess.run(sys.argv[1:]).returncode\n\
    print('\\npeak', resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)\n\
    sys.exit(code if code >= 0 else 200)";

/// Bakes a small table of rays as `table.h5` in `folder`.
fn table(folder: &Path) {
    let options = "--method rays --rays 16384 --bins 16";
    let table = bake_table_with(folder, "triangular", "0,20", "30", options);
    std::fs::rename(folder.join(table), folder.join("table.h5")).unwrap();
}

#[test]
#[ignore = "takes a minute: a hundred files; `make test-kills` runs it"]
fn every_hostile_file_is_refused_in_little_time_and_memory() {
    let folder = tempfile::tempdir().unwrap();
    table(folder.path());
    let listed = Command::new(python())
        .arg(argument("tests/tests/hostile.py"))
        .arg(folder.path())
        .output()
        .unwrap();
    assert!(
        listed.status.success(),
        "{}",
        String::from_utf8_lossy(&listed.stderr)
    );
    let listed = String::from_utf8(listed.stdout).unwrap();
    let (mut wrong, mut cases) = (Vec::new(), 0);
    let (mut slowest, mut largest) = ((0.0, ""), (0, ""));
    for line in listed.lines() {
        let mut words: Vec<&str> = line.split('\t').collect();
        let (name, says) = (words.remove(0), words.pop().unwrap());
        let start = Instant::now();
        let run = run_by(
            &[&python(), "-c".as_ref(), MEASURE.as_ref()],
            words[0],
            folder.path(),
            &words[1..],
        );
        let seconds = start.elapsed().as_secs_f64();
        let (out, peak) = run.out.rsplit_once("peak ").expect("the measure prints it");
        let bytes = 1024 * peak.trim().parse::<u64>().unwrap();
        let told = run.err.lines().filter(|line| line.starts_with("error: "));
        let one = told.clone().count() == 1
            && told
                .clone()
                .all(|line| line.contains(says) && line.contains(';'));
        if run.code != Some(1) || !one || !out.trim().is_empty() || run.err.contains("panicked") {
            wrong.push(format!("{name}: code {:?}, {}", run.code, run.err));
        }
        if bytes > MOST_BYTES || seconds > MOST_SECONDS {
            wrong.push(format!("{name}: {bytes} bytes, {seconds:.1} s"));
        }
        println!(
            "{name}: {seconds:.2} s, {} MB: {}",
            bytes / 1_000_000,
            run.err.trim()
        );
        slowest = if seconds > slowest.0 {
            (seconds, name)
        } else {
            slowest
        };
        largest = if bytes > largest.0 {
            (bytes, name)
        } else {
            largest
        };
        cases += 1;
    }
    assert!(
        wrong.is_empty(),
        "{} of {cases}:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
    assert_eq!(cases, 59 + 3 * 11 + 5 + 5 + 1);
    println!("slowest {slowest:?}, largest {largest:?}");
}

/// Random changes of HDF5 structures without checksums end in a table or in an error. A signal must
/// never end the program.
#[test]
#[ignore = "takes a minute: 150 runs; `make test-kills` runs it"]
fn a_crash_of_the_hdf5_library_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    table(folder.path());
    let old = folder.path().join("old.h5");
    let script = "import h5py, sys\n\
        with h5py.File(sys.argv[1]) as new, h5py.File(sys.argv[2], 'w', libver='earliest') as \
        old:\n\
        \x20   for name in new: new.copy(name, old)\n\
        \x20   old.attrs.update(new.attrs)";
    let status = Command::new(python())
        .args(["-c", script])
        .args([&folder.path().join("table.h5"), &old])
        .status()
        .unwrap();
    assert!(status.success());
    let whole = std::fs::read(&old).unwrap();
    let (mut read, mut refused, mut crashed) = (0, 0, 0);
    let mut state = 1_u64;
    let mut below = |n: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % n
    };
    for _ in 0..150 {
        let mut changed = whole.clone();
        for _ in 0..8 {
            let at = below(changed.len().min(20_000));
            changed[at] = [0, 1, 0x7f, 0x80, 0xff][below(5)];
        }
        std::fs::write(folder.path().join("changed.h5"), changed).unwrap();
        let run = tests::program::bake(folder.path(), "inspect changed.h5");
        match run.code {
            Some(0) => read += 1,
            Some(1) if run.err.contains("the process that reads it") => crashed += 1,
            Some(1) if run.err.starts_with("error: changed.h5: ") => refused += 1,
            _ => panic!("{:?}: {}", run.code, run.err),
        }
    }
    println!(
        "of 150 changed files {read} read, {refused} refused, {crashed} crashed the reading process"
    );
    assert_eq!(read + refused + crashed, 150);
    assert!(refused > 20, "the changes did not reach the structures");
}
