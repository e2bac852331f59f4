//! Limits of a process that only reads a table, and of what the file may claim in it.
//!
//! The hard limits follow from the length of the file and cannot be raised again ([`begin`]). Below
//! them soft limits grow with what the file claims.

use std::cell::Cell;
use std::path::Path;
use std::sync::OnceLock;
use std::time::Instant;

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use crate::error::Error;
use crate::file::limits::{most_content, processor};

/// Limits this process to `bytes` of address space and `seconds` of the processor since its start.
///
/// Limits can be raised again, up to those of [`cap`]. If the system refuses, the process goes on
/// without them.
pub(crate) fn set(bytes: u64, seconds: u64) {
    limit(Resource::As, bytes, None);
    limit(Resource::Cpu, seconds, None);
}

/// Limits this process for the rest of its life, and forbids it a core file.
///
/// Returns whether the system took all limits.
pub(crate) fn cap(bytes: u64, seconds: u64) -> bool {
    let memory = limit(Resource::As, bytes, Some(bytes));
    // The soft limit of the processor's time sends a signal that can be told from others.
    let time = limit(Resource::Cpu, seconds, Some(seconds + 1));
    let core = limit(Resource::Core, 0, Some(0));
    memory && time && core
}

/// Sets a soft limit, and a hard one if it is given, no higher than the hard limit that there is.
///
/// Returns whether the system took it.
fn limit(resource: Resource, soft: u64, hard: Option<u64>) -> bool {
    let most = getrlimit(resource).maximum;
    let below = |wanted: u64| Some(most.map_or(wanted, |most| wanted.min(most)));
    let limit = Rlimit {
        current: below(soft),
        maximum: hard.map_or(most, below),
    };
    setrlimit(resource, limit).is_ok()
}

/// Sum of what the arrays of a file have claimed so far.
pub(crate) struct Ledger {
    file_bytes: u64,
    claimed: Cell<u64>,
}

impl Ledger {
    /// Starts the ledger of a file of this length, bytes.
    pub(crate) fn new(file_bytes: u64) -> Ledger {
        Ledger {
            file_bytes,
            claimed: Cell::new(0),
        }
    }

    /// Adds an array to the claims, before memory is allocated for it.
    ///
    /// # Errors
    /// Returns an [`Error`] if the claims exceed what a file of this length may hold.
    pub(crate) fn enter(&self, file: &Path, bytes: u64) -> Result<(), Error> {
        let claimed = self.claimed.get().saturating_add(bytes);
        self.claimed.set(claimed);
        if claimed > most_content(self.file_bytes) {
            let bytes = self.file_bytes;
            return Err(Error::file(
                file,
                format!(
                    "claims {claimed} bytes of content in a file of {bytes}, as a decompression \
                    bomb does"
                ),
                "if you trust it, store it uncompressed with `h5repack -f NONE`",
            ));
        }
        grant(self.file_bytes, claimed);
        Ok(())
    }
}

/// Time at which the process became one that only reads a table.
static CONFINED: OnceLock<Instant> = OnceLock::new();

/// Makes this a process that only reads a table of this length, under hard limits.
///
/// Returns whether the system took them.
pub(crate) fn begin(file_bytes: u64) -> bool {
    let _ = CONFINED.set(Instant::now());
    let most = most_content(file_bytes);
    cap(memory(file_bytes, most), processor(file_bytes, most))
}

/// Limits what the HDF5 library may take in a process that only reads a table; does nothing
/// elsewhere.
pub(crate) fn confine(file_bytes: u64) {
    grant(file_bytes, 0);
}

/// Sets the soft limits for `claimed` bytes of content.
///
/// Time: what has passed on the clock, of which the processor has spent less here, and what the
/// claims may take.
fn grant(file_bytes: u64, claimed: u64) {
    let Some(start) = CONFINED.get() else { return };
    let seconds = start.elapsed().as_secs() + 2 + (claimed >> 25);
    set(memory(file_bytes, claimed), seconds);
}

/// Returns the memory for a file and `claimed` bytes of content, bytes.
///
/// The file is held twice while the library copies it. Half as much again as the content follows
/// from the counts. 192 MiB are for the program and one chunk.
fn memory(file_bytes: u64, claimed: u64) -> u64 {
    (192 << 20) + 2 * file_bytes + claimed + claimed / 2
}
