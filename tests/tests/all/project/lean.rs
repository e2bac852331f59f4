//! The lean fitter, which is `fit` built with `--no-default-features`.
//!
//! It has photographs, model, estimate, result and prediction. It has no code that draws, and no
//! HDF5: `airr-reader` opens tables for it.

use std::collections::BTreeSet;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use tests::files::{argument, bake_table, project};

/// Crates that only the default features need: for plots, pictures as text, and
/// progress bars.
const FEATURES_BRING: [&str; 3] = ["charts", "base64", "indicatif"];

/// Crates that `bake` and `airr-reader` need to open tables, and no `fit`.
const OPEN_TABLES: [&str; 3] = ["hdf5-metno", "hdf5-metno-sys", "hdf5-metno-src"];

fn cargo(line: &str) -> Command {
    let mut command = Command::new(env!("CARGO"));
    command.current_dir(project()).args(line.split_whitespace());
    command
}

/// Runs `cargo tree` and returns its lines.
fn tree(options: &str) -> BTreeSet<String> {
    let line = format!("tree --locked --offline --prefix none {options}");
    let output = cargo(&line).output().expect("cargo runs");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{line}: {errors}");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let lines = text
        .lines()
        .map(|line| line.trim_end_matches(" (*)").trim());
    lines
        .filter(|line| !line.is_empty())
        .map(str::to_owned)
        .collect()
}

/// Returns the names and versions of all crates in a build of `fit`, with `fit` itself.
///
/// `edges` says which dependencies count, for example `normal,build`.
fn crates(features: &str, edges: &str) -> BTreeSet<String> {
    // Two versions of a crate count as two crates.
    let name = |line: &String| {
        let words: Vec<&str> = line.split_whitespace().take(2).collect();
        words.join(" ")
    };
    let lines = tree(&format!("-p fit --edges {edges} {features}"));
    lines.iter().map(name).collect()
}

/// Tests of one crate compile nothing anew after tests of the workspace: each third crate has the
/// same features in both. What a crate lacks is added to its dev-dependencies.
#[test]
fn one_crate_alone_has_the_features_of_the_workspace() {
    let of = |part: &str| tree(&format!("-e normal,build,dev -f {{p}}@{{f}} {part}"));
    // Without arguments these are the members that cargo takes by default: all but the module of
    // Python, whose macros want more features. `make test` takes it too, in every step.
    for (all, few) in [
        ("", "-p fit"),
        ("", "-p estimator"),
        ("", "-p lab"),
        ("", "-p pictures"),
        ("", "-p bake"),
        ("--workspace", "-p fit -p midair"),
    ] {
        let (all, few_of) = (of(all), of(few));
        assert!(few_of.len() > 80, "{few:?}: {}", few_of.len());
        let other: Vec<&String> = few_of.difference(&all).collect();
        assert!(other.is_empty(), "{few:?} would compile anew: {other:#?}");
        println!("{few:?}: {} crates as in the workspace", few_of.len());
    }
}

#[test]
fn the_lean_tree_has_no_crate_that_draws_and_no_hdf5() {
    let lean = crates("--no-default-features", "normal,build");
    let full = crates("", "normal,build");
    let has = |tree: &BTreeSet<String>, name: &str| {
        tree.iter().any(|held| held.split(' ').next() == Some(name))
    };
    for name in FEATURES_BRING {
        assert!(has(&full, name), "{name} is gone: take it from this list");
        assert!(!has(&lean, name), "the lean fitter brings {name}");
    }
    let bake: BTreeSet<String> = tree("-p bake --edges normal,build");
    for name in OPEN_TABLES {
        assert!(has(&bake, name), "{name} is gone: take it from this list");
        assert!(!has(&full, name), "fit brings {name}");
    }
    assert!(lean.is_subset(&full));
    println!(
        "crates, build scripts' own among them: {} lean, {} full",
        lean.len(),
        full.len()
    );
}

/// Builds the lean program from nothing in a folder of its own, without a C++ compiler.
///
/// Returns the path of the program and the seconds of the build.
fn built() -> (PathBuf, f64) {
    let target = project().join("target").join("lean");
    if target.exists() {
        std::fs::remove_dir_all(&target).expect("an old build goes");
    }
    let started = Instant::now();
    let status = cargo("build --release --locked -p fit --no-default-features")
        .arg("--target-dir")
        .arg(&target)
        .env("CXX", "no-such-compiler")
        .status()
        .expect("cargo runs");
    assert!(status.success());
    let seconds = started.elapsed().as_secs_f64();
    let program = target.join("release").join("fit");
    // Tables are opened by a program that stands beside it.
    let reader = tests::program::fresh("airr-reader");
    symlink(reader, program.with_file_name("airr-reader")).expect("a link");
    (program, seconds)
}

/// Runs a program and returns its exit code, and its standard output followed by standard error.
fn run(program: &Path, folder: &Path, line: &str) -> (Option<i32>, String) {
    let output = Command::new(program)
        .current_dir(folder)
        .args(line.split_whitespace())
        .output()
        .expect("the lean program starts");
    let said = [output.stdout, output.stderr].concat();
    (
        output.status.code(),
        String::from_utf8_lossy(&said).into_owned(),
    )
}

#[test]
#[ignore = "builds the lean program from nothing, which takes minutes: `make test-lean`"]
fn the_lean_program_does_its_verbs() {
    let (program, seconds) = built();
    let megabytes = program.metadata().expect("it was built").len() as f64 / 1e6;
    println!(
        "lean: {} crates, {seconds:.0} s from nothing, {megabytes:.1} MB",
        crates("--no-default-features", "normal").len()
    );
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let table = bake_table(here, "triangular-pair", "0:45:5", "30");
    let manifest = argument("tests/captures/public_per_angle/captures.toml");
    let photograph = argument("tests/captures/public_per_angle/source.exr");
    for line in [
        &format!("estimate {manifest} --table {table} -o result.json"),
        &format!("mtf {photograph} -o mtf.csv"),
        &format!("predict result.json --table {table} --distance 150 --incidence 20 --json"),
    ] {
        let (code, said) = run(&program, here, line);
        assert_eq!(code, Some(0), "fit {line}\n{said}");
    }
    // The lean program does not offer missing verbs and options. To ask for one is wrong usage.
    for line in [
        "render",
        "simulate",
        "study",
        "export",
        &format!("estimate {manifest} --table {table} --plot a.svg"),
        &format!("estimate {manifest} --table {table} --report a.html"),
    ] {
        let (code, said) = run(&program, here, line);
        assert_eq!(code, Some(2), "fit {line}\n{said}");
        assert!(
            said.contains("unrecognized subcommand") || said.contains("unexpected argument"),
            "{said}"
        );
    }
    for verb in ["estimate", "mtf", "predict"] {
        let (_, help) = run(&program, here, &format!("{verb} --help"));
        for option in ["--plot", "--report", "--against"] {
            assert!(!help.contains(option), "fit {verb} --help names {option}");
        }
    }
}
