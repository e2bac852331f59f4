//! Side of the program that reads tables for others: limits before, an answer after.

use std::io::{self, BufWriter, Read, Write};
use std::path::Path;

use crate::file::reader::{OTHER_VERSION, Protection, REFUSAL, TABLE, VERSION};
use crate::library;

/// Makes this a process that only reads a table of this length, under hard limits.
///
/// Returns whether the system took them.
#[must_use]
pub fn begin(file_bytes: u64) -> bool {
    library::confine::begin(file_bytes)
}

/// Reads a table of `file_bytes` bytes and writes it, or the refusal, to `out`.
///
/// `name` is for messages. `lacking` are the protections that the system did not give.
///
/// # Errors
/// Returns the error of writing to `out`.
pub fn answer(
    name: &Path,
    from: impl Read,
    file_bytes: u64,
    lacking: &[Protection],
    out: impl Write,
) -> io::Result<()> {
    let missing = lacking.iter().fold(0, |bits, one| bits | one.bit());
    let content = library::read::content(from, file_bytes, name);
    let table = content.and_then(|content| library::read::table(content, name));
    let mut out = BufWriter::with_capacity(1 << 16, out);
    match table {
        Ok(table) => {
            out.write_all(&[TABLE, missing])?;
            let mut sent = Ok(());
            table.content(&mut |bytes| {
                if sent.is_ok() {
                    sent = out.write_all(bytes);
                }
            });
            sent?;
        }
        Err(error) => {
            out.write_all(&[REFUSAL, missing])?;
            write!(out, "{error}")?;
        }
    }
    out.flush()
}

/// Answers a program of another version.
///
/// # Errors
/// Returns the error of writing to `out`.
pub fn answer_other_version(mut out: impl Write) -> io::Result<()> {
    out.write_all(&[OTHER_VERSION, 0])?;
    write!(out, "{VERSION}")?;
    out.flush()
}
