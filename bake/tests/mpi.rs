//! Tests of the ranks of `mpirun`.
//!
//! The table has the same bytes with any number of ranks, every message comes once, and no half
//! table is left if a rank dies. The tests need Open MPI or MPICH. They allow more ranks than
//! processors.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

const BAKE: &str = env!("CARGO_BIN_EXE_bake");

fn command(folder: &Path, program: &str, arguments: &str) -> Command {
    let mut command = Command::new(program);
    command
        .current_dir(folder)
        .args(arguments.split_whitespace())
        // Open MPI must be asked for permission to run as root, and with more ranks than cores.
        .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        .env("OMPI_MCA_rmaps_base_oversubscribe", "1");
    command
}

fn ranks(folder: &Path, count: usize, line: &str) -> Output {
    let arguments = format!("-n {count} {BAKE} {line}");
    let output = command(folder, "mpirun", &arguments).output();
    output.expect("mpirun runs: install Open MPI or MPICH")
}

fn alone(folder: &Path, line: &str) -> Output {
    command(folder, BAKE, line).output().expect("bake runs")
}

#[track_caller]
fn done(output: &Output) -> String {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Returns a folder with a cell in it.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    done(&alone(folder.path(), "design full-cube -o cell.obj"));
    folder
}

fn bytes(folder: &Path, file: &str) -> Vec<u8> {
    std::fs::read(folder.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
}

#[test]
fn one_two_and_four_ranks_bake_the_same_bytes() {
    let folder = folder();
    let here = folder.path();
    let mut compared = 0;
    for options in [
        "",
        "--method rays --rays 3000000 --incidence 0:60:20 --save-every 0",
        "--method rays --rays 300001 --sampler random --azimuth mean --incidence 0:60:20 \
        --threads 1",
        "--method rays --tolerance 0.02 --incidence 0:60:20",
        "--method rays --rays 100003 --shard 2/3 --incidence 0:60:20",
        "--method rays --rays 30001 --incidence 45 --refractive-index 1.49 --front trapped",
    ] {
        let report = done(&alone(here, &format!("trace cell.obj -o one.h5 {options}")));
        for count in [1, 2, 4] {
            let shared = ranks(here, count, &format!("trace cell.obj -o all.h5 {options}"));
            let (lines, alone) = (done(&shared).lines().count(), report.lines().count());
            assert_eq!(lines, alone, "{count} ranks say it once");
            assert!(bytes(here, "all.h5") == bytes(here, "one.h5"), "{options}");
            compared += 1;
        }
    }
    assert_eq!(compared, 18);
}

#[test]
fn errors_are_said_once_and_end_all() {
    let folder = folder();
    let here = folder.path();
    let rays = "--method rays --rays 50000 --save-every 0";
    done(&alone(
        here,
        &format!("trace cell.obj -o saved.h5 {rays} --seed 2"),
    ));
    std::fs::rename(here.join("saved.h5"), here.join("table.h5.resume")).expect("renames");
    std::fs::write(here.join("table.h5"), "old").expect("writes");
    let cases = [
        ("trace cell.obj -o table.h5 --no-such-option", 2),
        ("trace cell.obj -o table.h5 --rays 0", 2),
        ("trace missing.obj -o table.h5", 1),
        ("trace cell.obj -o missing/table.h5", 1),
        ("trace cell.obj -o table.h5 --shard 1/2", 2),
        (&format!("trace cell.obj -o table.h5 {rays} --resume"), 2),
        ("inspect missing.h5", 1),
        // Rank 2 gets another mesh, and in the next case a mesh that does not exist.
        (
            &format!(
                "trace cell.obj -o table.h5 {rays} : -n 1 {BAKE} trace other.obj -o table.h5 {rays}"
            ),
            1,
        ),
        (
            &format!(
                "trace cell.obj -o table.h5 {rays} : -n 1 {BAKE} trace missing.obj -o table.h5 \
                {rays}"
            ),
            1,
        ),
    ];
    done(&alone(here, "design triangular -o other.obj"));
    for (line, code) in &cases {
        let begun = Instant::now();
        let output = ranks(here, 2, line);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(*code), "{line}: {said}");
        assert_eq!(said.matches("error: ").count(), 1, "{line}: {said}");
        assert!(begun.elapsed() < Duration::from_secs(60), "{line}: it hung");
        assert!(bytes(here, "table.h5") == b"old", "{line}");
    }
    assert_eq!(cases.len(), 9);
    let help = done(&ranks(here, 2, "trace --help"));
    assert_eq!(help.matches("Usage:").count(), 1, "{help}");
    let design = done(&ranks(here, 2, "design triangular -o made.obj"));
    assert_eq!(design, "");
    assert!(bytes(here, "made.obj") == bytes(here, "other.obj"));
}

/// Returns the processes that `parent` started, in that order: the ranks.
fn children(parent: u32) -> Vec<String> {
    let listed = Command::new("ps")
        .args(["-o", "pid=,comm=", "--ppid", &parent.to_string()])
        .output()
        .expect("ps runs");
    let lines = String::from_utf8_lossy(&listed.stdout).into_owned();
    let rank = |line: &str| {
        let (pid, name) = line.trim().split_once(' ')?;
        (name.trim() == "bake").then(|| pid.to_owned())
    };
    lines.lines().filter_map(rank).collect()
}

#[test]
fn a_rank_that_dies_ends_all_and_leaves_the_old_table() {
    let folder = folder();
    let here = folder.path();
    let line = "trace cell.obj -o table.h5 --method rays --rays 40000000 --incidence 0:60:20 \
    --bins 64 --save-every 0";
    done(&alone(here, &line.replace("table.h5", "whole.h5")));
    let whole = bytes(here, "whole.h5");
    let mut kills = 0;
    for victim in [0, 1, 1, 0, 1] {
        std::fs::write(here.join("table.h5"), "old").expect("writes");
        let mut run = command(here, "mpirun", &format!("-n 2 {BAKE} {line} --resume"))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("mpirun runs");
        // The rank is killed after the first save.
        let saved = here.join("table.h5.resume");
        let before = saved.metadata().and_then(|data| data.modified()).ok();
        let begun = Instant::now();
        let news = || saved.metadata().and_then(|data| data.modified()).ok() != before;
        while !news() && run.try_wait().expect("it can be asked").is_none() {
            assert!(
                begun.elapsed() < Duration::from_secs(120),
                "nothing is saved"
            );
            std::thread::sleep(Duration::from_millis(2));
        }
        let Some(pid) = children(run.id()).get(victim).cloned() else {
            panic!("it was done before rank {victim} could be killed: give it more rays");
        };
        let sent = Command::new("kill").args(["-s", "KILL", &pid]).status();
        assert!(sent.expect("kill runs").success());
        let status = run.wait().expect("it ends");
        assert!(!status.success(), "{status}");
        assert!(
            begun.elapsed() < Duration::from_secs(120),
            "the others hung"
        );
        assert!(bytes(here, "table.h5") == b"old", "the old table is whole");
        kills += 1;
    }
    assert_eq!(kills, 5);
    // A saved bake goes on with any number of ranks.
    done(&ranks(here, 4, &format!("{line} --resume")));
    assert!(bytes(here, "table.h5") == whole);
    assert!(!here.join("table.h5.resume").exists());
}
