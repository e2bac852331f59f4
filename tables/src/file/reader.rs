//! Side of the program that reads tables for others: limits before, an answer after.
//!
//! `airr-reader` uses it, and nothing else should. [`crate::apart`] is the other side.
//!
//! The answer is one byte that says what it is, one byte of the protections that are missing, and
//! then the table (the items of its content hash) or the refusal in words.

use std::io::{self, BufWriter, Read, Write};
use std::path::Path;

use crate::file::{limits, read};

/// Version of this crate, which both programs must share.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// First byte of an answer that is a table.
pub(crate) const TABLE: u8 = b'T';
/// First byte of an answer that is a refusal in words.
pub(crate) const REFUSAL: u8 = b'R';
/// First byte of an answer that names the reader's version, which is not the asked one.
pub(crate) const OTHER_VERSION: u8 = b'V';

/// Protection that keeps the process that reads a table from doing anything else.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Protection {
    /// Memory and time that follow from the length of the file.
    Limits,
    /// No file can be opened (Landlock).
    Files,
    /// Nothing can be asked of the system but memory and the answer (seccomp).
    Calls,
}

impl Protection {
    /// All protections.
    pub const ALL: [Protection; 3] = [Protection::Limits, Protection::Files, Protection::Calls];

    /// Returns the protection in words, for a sentence.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Protection::Limits => "limits of memory and time",
            Protection::Files => "Landlock (Linux 5.13 or later)",
            Protection::Calls => "seccomp (Linux on x86-64, ARM64 or RISC-V)",
        }
    }

    /// Returns the bit of the protection in an answer.
    fn bit(self) -> u8 {
        1 << self as u8
    }

    /// Returns the protections whose bits are set.
    pub(crate) fn of(bits: u8) -> Vec<Protection> {
        let mut found = Protection::ALL.to_vec();
        found.retain(|one| bits & one.bit() != 0);
        found
    }
}

/// Makes this a process that only reads a table of this length, under hard limits.
///
/// Returns whether the system took them.
#[must_use]
pub fn begin(file_bytes: u64) -> bool {
    limits::begin(file_bytes)
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
    let content = read::content(from, file_bytes, name);
    let table = content.and_then(|content| read::table(content, name));
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
