//! What the program that reads tables and those that ask it share: first bytes of answers, and
//! protections.
//!
//! `airr-reader` uses it, and nothing else should. [`crate::apart`] is the other side.
//!
//! The answer is one byte that says what it is, one byte of the protections that are missing, and
//! then the table (the items of its content hash) or the refusal in words.

#[cfg(feature = "hdf5")]
pub use crate::library::answer::{answer, answer_other_version, begin};

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
    pub(crate) fn bit(self) -> u8 {
        1 << self as u8
    }

    /// Returns the protections whose bits are set.
    pub(crate) fn of(bits: u8) -> Vec<Protection> {
        let mut found = Protection::ALL.to_vec();
        found.retain(|one| bits & one.bit() != 0);
        found
    }
}
