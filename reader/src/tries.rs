//! What a confined process may not do, tried.

use std::fs::File;
use std::io::{self, Write};
use std::mem::ManuallyDrop;
use std::net::{TcpStream, UdpSocket};
use std::path::PathBuf;
use std::process::{Command, ExitCode};
use std::thread;

use tables::reader::Protection;

use crate::confine::confine;

/// File that a process without rights fails to make.
const TRACE: &str = "airr-reader-was-here";

/// What a process had before it was confined.
struct Before {
    /// Path of this program, a file that could be read and started.
    program: PathBuf,
    /// This program, open.
    open: ManuallyDrop<File>,
    /// Number of the process that started this one.
    parent: u32,
}

/// Something that a confined process tries: its name, and a function.
type Try = (&'static str, fn(&Before) -> io::Result<()>);

/// Confines this process as for a table, tries everything, and prints a line for each try.
///
/// The exit code is 0 if all tries are refused and all lines are printed.
pub(crate) fn run(mut out: impl Write) -> ExitCode {
    let before = match before() {
        Ok(before) => before,
        Err(error) => {
            let _ = writeln!(out, "this program does not find itself ({error})");
            return ExitCode::FAILURE;
        }
    };
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
        let said = match tried(&before) {
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

/// Opens this program, and asks for its parent.
fn before() -> io::Result<Before> {
    let program = std::env::current_exe()?;
    Ok(Before {
        // The file is closed behind Rust's back, and must not be closed again.
        open: ManuallyDrop::new(File::open(&program)?),
        program,
        #[cfg(unix)]
        parent: std::os::unix::process::parent_id(),
        #[cfg(not(unix))]
        parent: 0,
    })
}

/// Maps the first bytes of a file into memory, for reading.
#[cfg(target_os = "linux")]
#[allow(unsafe_code, reason = "a call into the system that Rust does not wrap")]
pub(crate) fn map(file: &File) -> io::Result<()> {
    use std::os::fd::AsRawFd;
    let (read, shared) = (libc::PROT_READ, libc::MAP_SHARED);
    // SAFETY: the system chooses the place, and nothing looks there.
    let place = unsafe { libc::mmap(std::ptr::null_mut(), 1, read, shared, file.as_raw_fd(), 0) };
    match place {
        libc::MAP_FAILED => Err(io::Error::last_os_error()),
        _ => Ok(()),
    }
}

/// Returns all tries.
fn tries() -> Vec<Try> {
    let mut tries: Vec<Try> = vec![
        ("open a file", |before| {
            File::open(&before.program).map(drop)
        }),
        ("make a file", |_| File::create(TRACE).map(drop)),
        ("remove a file", |_| std::fs::remove_file(TRACE)),
        ("list a folder", |_| std::fs::read_dir("/").map(drop)),
        ("ask for a file's length", |before| {
            std::fs::metadata(&before.program).map(drop)
        }),
        ("bind a socket", |_| {
            UdpSocket::bind("127.0.0.1:0").map(drop)
        }),
        ("connect a socket", |_| {
            match TcpStream::connect("127.0.0.1:9") {
                // The network answered: it was asked.
                Err(error) if error.kind() == io::ErrorKind::ConnectionRefused => Ok(()),
                tried => tried.map(drop),
            }
        }),
        ("start a process", |before| {
            let mut child = Command::new(&before.program).arg("--version").spawn()?;
            child.wait().map(drop)
        }),
        ("start a thread", |_| {
            thread::Builder::new().spawn(|| ()).map(drop)
        }),
        ("take 4 GiB of memory", |_| {
            let mut bytes: Vec<u8> = Vec::new();
            Ok(bytes.try_reserve_exact(4 << 30)?)
        }),
    ];
    #[cfg(target_os = "linux")]
    tries.push(("map a file that was open", |before| map(&before.open)));
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
        ("make a socket pair", |_| UnixDatagram::pair().map(drop)),
        ("become another program", |before| {
            Err(Command::new(&before.program).arg("--version").exec())
        }),
        ("signal its parent", |before| {
            let parent = i32::try_from(before.parent).ok().and_then(Pid::from_raw);
            Ok(test_kill_process(parent.ok_or(io::ErrorKind::NotFound)?)?)
        }),
        ("raise a hard limit", |_| {
            let limit = Rlimit {
                current: None,
                maximum: None,
            };
            Ok(setrlimit(Resource::As, limit)?)
        }),
    ]
}
