//! The reader as it is started: what it may not do, and what it says to a person.

#[path = "../../tables/tests/all/sample/mod.rs"]
mod sample;

use std::io::Read;
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
    assert_eq!(tried.len(), 15, "{said}");
    assert_eq!(output.status.code(), Some(0), "{said}");
}

/// A file that the caller left open is closed before the table is read.
///
/// The answer to the table is longer than a pipe holds. So the reader waits for this test, and the
/// system lists what it has open.
#[cfg(target_os = "linux")]
#[test]
fn files_of_the_caller_are_closed() {
    let folder = tempfile::tempdir().expect("a folder");
    let precious = folder.path().join("precious");
    std::fs::write(&precious, "mine").expect("a file");
    let table = folder.path().join("table.h5");
    let mut whole = sample::rays(2, 7);
    whole.provenance.design = "x".repeat(1 << 20);
    tables::write(&whole, &table).expect("a table");
    let mut child = Command::new("sh")
        .args(["-c", "exec \"$@\" 7<>\"$0\""])
        .arg(&precious)
        .args([env!("CARGO_BIN_EXE_airr-reader"), tables::reader::VERSION])
        .arg("table.h5")
        .stdin(std::fs::File::open(&table).expect("the table"))
        .stdout(std::process::Stdio::piped())
        .spawn()
        .expect("sh starts");
    let mut out = child.stdout.take().expect("a pipe");
    let mut head = [0; 2];
    out.read_exact(&mut head).expect("the start of the answer");
    let open = std::fs::read_dir(format!("/proc/{}/fd", child.id())).expect("it waits");
    let mut open: Vec<_> = open
        .map(|entry| entry.expect("a descriptor").file_name())
        .collect();
    open.sort();
    out.read_to_end(&mut Vec::new()).expect("the rest");
    assert!(child.wait().expect("it ends").success());
    assert_eq!(
        (head[0], &open[..]),
        (b'T', &["0", "1", "2"].map(Into::into)[..])
    );
    println!("{} descriptors", open.len());
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
