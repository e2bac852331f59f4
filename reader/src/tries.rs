//! What a confined process may not do, tried.

use std::fs::File;
use std::io::{self, Write};
use std::net::{TcpStream, UdpSocket};
use std::path::Path;
use std::process::{Command, ExitCode};
use std::thread;

use tables::reader::Protection;

use crate::confine::confine;

/// File that a process without rights fails to make.
const TRACE: &str = "airr-reader-was-here";

/// Something that a confined process tries: its name, and a function that gets the path of this
/// program and the number of its parent, which were read before.
type Try = (&'static str, fn(&Path, u32) -> io::Result<()>);

/// Confines this process as for a table, tries everything, and prints a line for each try.
///
/// The exit code is 0 if all tries are refused and all lines are printed.
pub(crate) fn run(mut out: impl Write) -> ExitCode {
    let program = std::env::current_exe().unwrap_or_default();
    let parent = parent();
    let lacking = confine(0);
    let (mut refused, mut printed) = (true, true);
    for protection in Protection::ALL {
        let has = if lacking.contains(&protection) {
            "lacks"
        } else {
            "has"
        };
        printed &= writeln!(out, "{has} {}", protection.words()).is_ok();
    }
    for (what, tried) in tries() {
        let said = match tried(&program, parent) {
            Ok(()) => {
                refused = false;
                "ALLOWED".to_owned()
            }
            Err(error) => format!("refused ({error})"),
        };
        printed &= writeln!(out, "{what}: {said}").is_ok();
    }
    if refused && printed {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

/// Returns the number of the process that started this one.
fn parent() -> u32 {
    #[cfg(unix)]
    return std::os::unix::process::parent_id();
    #[cfg(not(unix))]
    0
}

/// Returns all tries. The program is a file that could be read and started before.
fn tries() -> Vec<Try> {
    let mut tries: Vec<Try> = vec![
        ("open a file", |program, _| File::open(program).map(drop)),
        ("make a file", |_, _| File::create(TRACE).map(drop)),
        ("remove a file", |_, _| std::fs::remove_file(TRACE)),
        ("list a folder", |_, _| std::fs::read_dir("/").map(drop)),
        ("ask for a file's length", |program, _| {
            std::fs::metadata(program).map(drop)
        }),
        ("bind a socket", |_, _| {
            UdpSocket::bind("127.0.0.1:0").map(drop)
        }),
        ("connect a socket", |_, _| {
            match TcpStream::connect("127.0.0.1:9") {
                // The network answered: it was asked.
                Err(error) if error.kind() == io::ErrorKind::ConnectionRefused => Ok(()),
                tried => tried.map(drop),
            }
        }),
        ("start a process", |program, _| {
            let mut child = Command::new(program).arg("--version").spawn()?;
            child.wait().map(drop)
        }),
        ("start a thread", |_, _| {
            thread::Builder::new().spawn(|| ()).map(drop)
        }),
        ("take 4 GiB of memory", |_, _| {
            let mut bytes: Vec<u8> = Vec::new();
            Ok(bytes.try_reserve_exact(4 << 30)?)
        }),
    ];
    #[cfg(unix)]
    tries.extend(of_unix());
    tries
}

/// Returns the tries that only Unix knows.
#[cfg(unix)]
fn of_unix() -> [Try; 4] {
    use rustix::process::{Pid, Resource, Rlimit, setrlimit, test_kill_process};
    use std::os::unix::net::UnixDatagram;
    use std::os::unix::process::CommandExt;

    [
        ("make a socket pair", |_, _| UnixDatagram::pair().map(drop)),
        ("become another program", |program, _| {
            Err(Command::new(program).arg("--version").exec())
        }),
        ("signal its parent", |_, parent| {
            let parent = i32::try_from(parent).ok().and_then(Pid::from_raw);
            Ok(test_kill_process(parent.ok_or(io::ErrorKind::NotFound)?)?)
        }),
        ("raise a hard limit", |_, _| {
            let limit = Rlimit {
                current: None,
                maximum: None,
            };
            Ok(setrlimit(Resource::As, limit)?)
        }),
    ]
}
