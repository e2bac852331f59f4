//! Reading of tables in a process of their own.
//!
//! The HDF5 library is written in C and trusts a file. A file that was made to do harm can crash it
//! or keep it busy without end, whatever is checked before: a stranger can compute every checksum
//! and seal. So a program starts its own executable again to open the file, under limits of memory
//! and time ([`serve`]). The second process sends back the content in the form in which it is
//! hashed, which is read without the library. If the second process crashes, the first one returns
//! an error.

use std::ffi::OsStr;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::error::Error;
use crate::file::here::here;
use crate::file::{ledger, limits, received};
use crate::table::table::Table;

/// First argument of a process that only reads a table.
const MARK: &str = "--read-table-apart";

/// First byte of an answer that is a table.
const TABLE: u8 = b'T';
/// First byte of an answer that is a refusal in words.
const REFUSAL: u8 = b'R';

/// Longest refusal that is read, bytes.
const MOST_WORDS: u64 = 1 << 16;

/// Set once [`serve`] has been called in the main process.
static SERVED: AtomicBool = AtomicBool::new(false);

/// Serves as the reading process, or makes [`crate::read()`] start such processes from now on.
///
/// Call it first in `main`. If this process was started to read a table, the call reads it and ends
/// the process. Without this call tables are read in the process itself, under the same checks.
pub fn serve() {
    let mut arguments = std::env::args_os().skip(1);
    if arguments.next().as_deref() == Some(OsStr::new(MARK)) {
        let path = PathBuf::from(arguments.next().unwrap_or_default());
        ledger::reader();
        std::process::exit(answer(&path).is_err().into());
    }
    SERVED.store(true, Ordering::Relaxed);
}

/// Reads a table and writes it, or the refusal, to standard output.
fn answer(path: &Path) -> io::Result<()> {
    let table = here(path);
    let mut out = BufWriter::with_capacity(1 << 16, io::stdout().lock());
    match table {
        Ok(table) => {
            out.write_all(&[TABLE])?;
            let mut sent = Ok(());
            table.content(&mut |bytes| {
                if sent.is_ok() {
                    sent = out.write_all(bytes);
                }
            });
            sent?;
        }
        Err(error) => write!(out, "{}{error}", REFUSAL as char)?,
    }
    out.flush()
}

/// Reads a table in a process of its own; `None` if [`serve`] was not called.
pub(crate) fn read(path: &Path) -> Option<Result<Table, Error>> {
    SERVED.load(Ordering::Relaxed).then(|| ask(path))
}

/// Starts a reading process, reads its answer and waits for its end.
fn ask(path: &Path) -> Result<Table, Error> {
    let failed = |what: String| Error::Apart {
        file: path.to_owned(),
        what,
    };
    // The link leads to this very program, even if another one has since been installed in its
    // place.
    let mut child = Command::new("/proc/self/exe")
        .arg(MARK)
        .arg(path)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|error| failed(format!("cannot be started ({error})")))?;
    let answer = child
        .stdout
        .take()
        .map(|out| listen(BufReader::with_capacity(1 << 16, out)));
    let status = child
        .wait()
        .map_err(|error| failed(format!("is lost ({error})")))?;
    match answer {
        Some(Ok(answer)) if status.success() => answer,
        Some(Err(error)) if status.success() => {
            Err(failed(format!("sent an answer that is no table ({error})")))
        }
        _ => Err(failed(end(status))),
    }
}

/// Reads the answer of a reading process: a table, or its refusal.
fn listen(mut from: BufReader<impl Read>) -> io::Result<Result<Table, Error>> {
    let mut kind = [0];
    from.read_exact(&mut kind)?;
    if kind == [TABLE] {
        return received::table(from).map(Ok);
    }
    let mut words = Vec::new();
    from.take(MOST_WORDS).read_to_end(&mut words)?;
    let words = String::from_utf8_lossy(&words).into_owned();
    Ok(Err(Error::Told(words)))
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
