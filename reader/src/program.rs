//! Arguments in, the answer out.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, Write};
use std::os::fd::AsFd;
use std::path::Path;
use std::process::ExitCode;

use tables::reader::{VERSION, answer, answer_other_version};

use crate::confine::confine;
use crate::tries;

/// Text for a person who starts the program.
const HELP: &str = "\
airr-reader opens ray-shift tables for bake and fit, in a process without rights to files, sockets
and other processes. They start it, and it is of no use alone.

Usage: airr-reader VERSION NAME < TABLE
       airr-reader --try       says what a confined process may not do
       airr-reader --version
";

/// Runs the program on its arguments (without the program's name) and returns its exit code.
///
/// The arguments are the version of the program that asks, and the name of the table for messages.
/// The table is standard input, the answer goes to standard output.
pub fn run(arguments: impl Iterator<Item = OsString>) -> ExitCode {
    let arguments: Vec<OsString> = arguments.take(3).collect();
    let mut out = io::stdout().lock();
    let (done, code) = match &arguments[..] {
        [only] if only == "--try" => return tries::run(out),
        [only] if only == "--version" => (writeln!(out, "airr-reader {VERSION}"), 0),
        [only] if only == "--help" || only == "-h" => (out.write_all(HELP.as_bytes()), 0),
        [version, _] if version != VERSION => (answer_other_version(out), 0),
        [_, name] => (serve(Path::new(name), out), 0),
        _ => {
            // Wrong usage stays wrong usage where it cannot be told.
            let _ = io::stderr().write_all(HELP.as_bytes());
            (Ok(()), 2)
        }
    };
    match done {
        Ok(()) => ExitCode::from(code),
        Err(_) => ExitCode::FAILURE,
    }
}

/// Gives up all rights, then reads the table on standard input.
fn serve(name: &Path, out: impl Write) -> io::Result<()> {
    let input = io::stdin();
    let bytes = File::from(input.as_fd().try_clone_to_owned()?)
        .metadata()?
        .len();
    let lacking = confine(bytes);
    answer(name, input.lock(), bytes, &lacking, out)
}
