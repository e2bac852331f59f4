//! Reading in a process of its own.
//!
//! The HDF5 library is C that takes a file at its word: one made to do harm can crash it or keep it
//! busy without end, whatever is checked before, for a stranger can compute every checksum and
//! seal. So a program lets its own executable, started again, open the file under limits of memory
//! and time ([`serve`]); what comes back is the content as it is hashed, which is read without the
//! library. A crash over there is an error here.

use std::ffi::OsStr;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::error::Error;
use crate::file::here::here;
use crate::file::{ledger, limits, received};
use crate::table::table::Table;

/// First argument of a process that only reads.
const MARK: &str = "--read-table-apart";

/// First byte of the answer: a table, or a refusal in words.
const TABLE: u8 = b'T';
const REFUSAL: u8 = b'R';

/// Longest refusal that is listened to, bytes.
const MOST_WORDS: u64 = 1 << 16;

static SERVED: AtomicBool = AtomicBool::new(false);

/// To be called first in `main`: where this process was started to read a table, it does so and
/// ends; else [`crate::read()`] starts such processes from now on.
///
/// Without this call tables are read in the process itself, under the same checks.
pub fn serve() {
    let mut arguments = std::env::args_os().skip(1);
    if arguments.next().as_deref() == Some(OsStr::new(MARK)) {
        let path = PathBuf::from(arguments.next().unwrap_or_default());
        ledger::reader();
        std::process::exit(answer(&path).is_err().into());
    }
    SERVED.store(true, Ordering::Relaxed);
}

/// What the reading process does.
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

/// Reads a table in a process of its own; nothing where [`serve`] was not called.
pub(crate) fn read(path: &Path) -> Option<Result<Table, Error>> {
    SERVED.load(Ordering::Relaxed).then(|| ask(path))
}

fn ask(path: &Path) -> Result<Table, Error> {
    let failed = |what: String| Error::Apart {
        file: path.to_owned(),
        what,
    };
    // The link leads to this very program, also where another was installed in its place since.
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
        Some(Err(error)) if status.success() => Err(failed(format!("answers nonsense ({error})"))),
        _ => Err(failed(end(status))),
    }
}

/// The table, or why there is none.
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

/// The end of a process in words.
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
