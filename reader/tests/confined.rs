//! The reader as it is started: what it may not do, and what it says to a person.

use std::process::{Command, Output};

/// Runs the reader without an environment.
fn reader(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_airr-reader"))
        .args(arguments)
        .env_clear()
        .current_dir(std::env::temp_dir())
        .output()
        .expect("the reader starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Every try of a confined process is refused by the system, and says so.
///
/// Raising a hard limit and starting things are refused to root too, by seccomp.
#[test]
fn a_confined_process_opens_nothing_and_starts_nothing() {
    let output = reader(&["--try"]);
    let said = text(&output.stdout);
    println!("{said}");
    if !cfg!(target_os = "linux") || said.contains("lacks") {
        println!("this system lacks a protection: the tries may be allowed");
        return;
    }
    let tried: Vec<&str> = said.lines().filter(|line| line.contains(": ")).collect();
    let wrong: Vec<&&str> = tried
        .iter()
        .filter(|line| !line.contains(": refused ("))
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert_eq!(tried.len(), 14, "{said}");
    assert_eq!(output.status.code(), Some(0), "{said}");
}

#[test]
fn a_person_is_told_what_it_is() {
    let help = reader(&["--help"]);
    assert_eq!(help.status.code(), Some(0));
    let alone = reader(&[]);
    assert_eq!(alone.status.code(), Some(2));
    assert_eq!(text(&help.stdout), text(&alone.stderr));
    assert!(text(&help.stdout).contains("They start it"));
    let version = text(&reader(&["--version"]).stdout);
    assert_eq!(
        version,
        format!("airr-reader {}\n", env!("CARGO_PKG_VERSION"))
    );
    // A program of another version gets the reader's own version, and nothing is read.
    let other = reader(&["0.0.1", "table.h5"]);
    assert_eq!(
        text(&other.stdout),
        format!("V\0{}", env!("CARGO_PKG_VERSION"))
    );
}

/// Text that cannot be printed is a failure, and wrong usage stays wrong usage.
#[cfg(target_os = "linux")]
#[test]
fn full_streams_have_their_exit_codes() {
    let full = || std::fs::File::options().write(true).open("/dev/full");
    let cases: [(&[&str], i32); 5] = [
        (&["--try"], 1),
        (&["--help"], 1),
        (&["--version"], 1),
        (&["0.0.1", "table.h5"], 1),
        (&[], 2),
    ];
    for (arguments, code) in cases {
        let status = Command::new(env!("CARGO_BIN_EXE_airr-reader"))
            .args(arguments)
            .stdin(std::process::Stdio::null())
            .stdout(full().expect("Linux has it"))
            .stderr(full().expect("Linux has it"))
            .status()
            .expect("the reader starts");
        assert_eq!(status.code(), Some(code), "{arguments:?}");
    }
    println!("{} runs", cases.len());
}
