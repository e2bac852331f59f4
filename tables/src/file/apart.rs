//! Reading of tables by another program.
//!
//! The HDF5 library is written in C and trusts a file. A file that was made to do harm can crash it
//! or keep it busy without end, whatever is checked before: a stranger can compute every checksum
//! and seal. So the library opens a file in `airr-reader`, a program beside this one, which has
//! hard limits of memory and time and no right to files, sockets or processes. It gets the file as
//! its standard input and no environment, and sends back the content in the form in which it is
//! hashed. The content is read here without the library. If the reader crashes, this program
//! returns an error.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread;
use std::time::Duration;

use crate::error::Error;
use crate::file::read::opened;
use crate::file::reader::{OTHER_VERSION, Protection, REFUSAL, TABLE, VERSION};
use crate::file::{limits, received};
use crate::table::table::Table;

/// Name of the reader, without the ending that programs have on some systems.
pub const READER: &str = "airr-reader";

/// Start of the names of the variables that steer the HDF5 library.
const VARIABLES: &str = "HDF5_";

/// Longest refusal that is read, bytes.
const MOST_WORDS: u64 = 1 << 16;

/// Path of the reader, once [`start`] or [`start_with`] has been called.
static PROGRAM: OnceLock<PathBuf> = OnceLock::new();

/// Makes [`crate::read()`] use the reader that stands beside this program.
///
/// Call it first in `main`. Without this call tables are read in the process itself, under the same
/// checks, if this crate has its feature `hdf5`. If there are variables `HDF5_...` in the environment, which can make the HDF5 library
/// load code, this program starts again without them.
pub fn start() {
    without_variables();
    start_with(beside());
}

/// Returns the path of the reader beside this program.
fn beside() -> PathBuf {
    let folder = std::env::current_exe().ok().and_then(|program| {
        let folder = program.parent()?;
        Some(folder.to_owned())
    });
    let name = format!("{READER}{}", std::env::consts::EXE_SUFFIX);
    folder.unwrap_or_default().join(name)
}

/// Makes [`crate::read()`] use this reader, for programs that do not stand beside it.
pub fn start_with(reader: PathBuf) {
    let _ = PROGRAM.set(reader);
}

/// Starts this program again without the variables of the HDF5 library, if there are any.
fn without_variables() {
    #[cfg(unix)]
    {
        use std::os::unix::process::CommandExt;
        let names = std::env::vars_os().map(|(name, _)| name);
        let found: Vec<_> = names
            .filter(|name| name.as_encoded_bytes().starts_with(VARIABLES.as_bytes()))
            .collect();
        let Ok(program) = std::env::current_exe() else {
            return;
        };
        if found.is_empty() {
            return;
        }
        let mut arguments = std::env::args_os();
        let mut again = Command::new(program);
        if let Some(name) = arguments.next() {
            again.arg0(name);
        }
        again.args(arguments);
        for name in &found {
            again.env_remove(name);
        }
        // It returns only if it fails. Then the library is still told to load nothing.
        let _ = again.exec();
    }
}

/// Table, and what the reader that opened it lacked.
#[derive(Debug)]
pub struct Reading {
    /// The table, checked.
    pub table: Table,
    /// Protections that the system did not give to the reader; all if there was no reader.
    pub lacking: Vec<Protection>,
}

/// Reads a table as [`crate::read()`] does, and says which protections were missing.
///
/// # Errors
/// Returns the errors of [`crate::read()`].
pub fn read(path: &Path) -> Result<Reading, Error> {
    let (file, bytes) = opened(path)?;
    read_file(file, bytes, path)
}

/// Reads a table of `bytes` bytes from an open file; `name` is for messages.
///
/// # Errors
/// Returns the errors of [`read`].
pub(crate) fn read_file(file: File, bytes: u64, name: &Path) -> Result<Reading, Error> {
    let program = match PROGRAM.get() {
        Some(program) => program,
        #[cfg(feature = "hdf5")]
        None => {
            let content = crate::library::read::content(file, bytes, name)?;
            return Ok(Reading {
                table: crate::library::read::table(content, name)?,
                lacking: Protection::ALL.to_vec(),
            });
        }
        #[cfg(not(feature = "hdf5"))]
        None => PROGRAM.get_or_init(beside),
    };
    ask(file, bytes, name, program)
}

/// Starts the reader, reads its answer and waits for its end.
fn ask(file: File, bytes: u64, path: &Path, program: &Path) -> Result<Reading, Error> {
    let failed = |what: String| {
        let fault = format!("the process that reads it with the HDF5 library {what}");
        let remedy = "the file is damaged or was made to do harm, copy it again or bake it again";
        Error::file(path, format!("cannot be read: {fault}"), remedy)
    };
    let unusable = |what: String| {
        let program = program.display();
        let fault =
            format!("{program}, the program that opens tables for `bake` and `fit`, {what}");
        let remedy =
            "put it beside this program, with `make install` or `cargo install --path reader`";
        Error::file(path, format!("cannot be read: {fault}"), remedy)
    };
    let mut child = Command::new(program)
        .arg(VERSION)
        .arg(path)
        .env_clear()
        .stdin(file)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|error| unusable(format!("cannot be started ({error})")))?;
    let out = child.stdout.take();
    let watched = Watched::new(child, limits::patience(bytes));
    let answer = out.map(|out| {
        // More than the file may claim does not come from the reader that was started.
        let most = 2 * limits::most_content(bytes);
        listen(BufReader::with_capacity(1 << 16, out.take(most)))
    });
    let (status, late) = watched
        .end()
        .map_err(|error| failed(format!("is lost ({error})")))?;
    match answer {
        _ if late => Err(failed("took too long".to_owned())),
        Some(Ok(Answer::Table(reading))) if status.success() => Ok(*reading),
        Some(Ok(Answer::Refusal(words))) if status.success() => Err(Error::Told(words)),
        Some(Ok(Answer::Version(version))) => Err(unusable(format!(
            "is of version {version:?}, this program of {VERSION}"
        ))),
        Some(Err(error)) if status.success() => {
            Err(failed(format!("sent an answer that is no table ({error})")))
        }
        _ => Err(failed(end(status))),
    }
}

/// Process that is ended if it takes too long.
struct Watched {
    child: Arc<Mutex<Child>>,
    done: Sender<()>,
    watch: thread::JoinHandle<bool>,
}

impl Watched {
    /// Starts the watch. Time in which this program is stopped does not count.
    fn new(child: Child, patience: Duration) -> Watched {
        const TICK: Duration = Duration::from_millis(100);
        let child = Arc::new(Mutex::new(child));
        let (done, ended) = channel();
        let watched = Arc::clone(&child);
        let watch = thread::spawn(move || {
            let mut waited = Duration::ZERO;
            while waited < patience {
                if ended.recv_timeout(TICK) != Err(RecvTimeoutError::Timeout) {
                    return false;
                }
                waited += TICK;
            }
            let mut child = watched.lock().unwrap_or_else(PoisonError::into_inner);
            child.kill().is_ok()
        });
        Watched { child, done, watch }
    }

    /// Waits for the end; returns how it ended, and whether it was ended because of the time.
    fn end(self) -> io::Result<(ExitStatus, bool)> {
        let status = loop {
            // The lock is free between the looks, for the watch.
            let look = self
                .child
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .try_wait()?;
            match look {
                Some(status) => break status,
                None => thread::sleep(Duration::from_millis(1)),
            }
        };
        let _ = self.done.send(());
        Ok((status, self.watch.join().unwrap_or(false)))
    }
}

/// Answer of a reader.
enum Answer {
    Table(Box<Reading>),
    Refusal(String),
    Version(String),
}

/// Reads the answer of a reader.
fn listen(mut from: BufReader<impl Read>) -> io::Result<Answer> {
    let mut head = [0; 2];
    from.read_exact(&mut head)?;
    let [kind, lacking] = head;
    if kind == TABLE {
        return Ok(Answer::Table(Box::new(Reading {
            table: received::table(from)?,
            lacking: Protection::of(lacking),
        })));
    }
    let mut words = Vec::new();
    from.take(MOST_WORDS).read_to_end(&mut words)?;
    let words = String::from_utf8_lossy(&words).into_owned();
    match kind {
        OTHER_VERSION => Ok(Answer::Version(words)),
        REFUSAL => Ok(Answer::Refusal(words)),
        _ => Err(io::Error::other(format!("its first byte is {kind}"))),
    }
}

/// Returns the end of a process in words.
fn end(status: ExitStatus) -> String {
    use std::os::unix::process::ExitStatusExt;
    match status.signal() {
        Some(limits::OUT_OF_TIME) => "took too long".to_owned(),
        Some(signal) => {
            format!("was ended by signal {signal}: it crashed or asked for too much memory")
        }
        None => format!("failed ({status})"),
    }
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;

    /// A process that neither answers nor ends: half a second of patience, not its ten minutes.
    #[test]
    fn a_process_without_end_is_ended() {
        let start = |seconds: &str| {
            Command::new("sleep")
                .arg(seconds)
                .spawn()
                .expect("sleep starts")
        };
        let clock = Instant::now();
        let watched = Watched::new(start("600"), Duration::from_millis(500));
        let (status, late) = watched.end().expect("it is waited for");
        assert!(late && !status.success(), "{status}");
        assert!(clock.elapsed() < Duration::from_secs(60));
        let watched = Watched::new(start("0"), Duration::from_secs(60));
        let (status, late) = watched.end().expect("it is waited for");
        assert!(!late && status.success(), "{status}");
    }
}
