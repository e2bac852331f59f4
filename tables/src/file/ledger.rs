//! Limits of what a file may cost: bytes of memory and seconds of the processor.
//!
//! Deflate packs zeros a thousandfold, so a small file may hold a large table, or claim to. A file
//! may claim up to [`FREE`] bytes of content. Above that, the content may be at most [`PACKED`]
//! times as long as the file; tables of a thousand rays a direction are within this.

use std::cell::Cell;
use std::path::Path;
use std::sync::OnceLock;
use std::time::Instant;

use crate::error::error::Error;
use crate::file::limits;

/// Number of bytes of content that any file may claim.
const FREE: u64 = 128 << 20;

/// Greatest ratio of claimed content to the length of the file, above [`FREE`].
const PACKED: u64 = 256;

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
    /// Returns [`Error::Inflated`] if the claims exceed what a file of this length may hold.
    pub(crate) fn enter(&self, file: &Path, bytes: u64) -> Result<(), Error> {
        let claimed = self.claimed.get().saturating_add(bytes);
        self.claimed.set(claimed);
        if claimed > FREE && claimed > self.file_bytes.saturating_mul(PACKED) {
            return Err(Error::Inflated {
                file: file.to_owned(),
                claimed,
                bytes: self.file_bytes,
            });
        }
        grant(claimed);
        Ok(())
    }
}

/// Time at which the process became one that only reads a table.
static CONFINED: OnceLock<Instant> = OnceLock::new();

/// Makes this a process that only reads a table, and may be stopped.
pub(crate) fn reader() {
    let _ = CONFINED.set(Instant::now());
}

/// Limits what the HDF5 library may take in a process that only reads a table; does nothing
/// elsewhere.
pub(crate) fn confine() {
    grant(0);
}

/// Sets the limits for `claimed` bytes of content.
///
/// Memory: the content, half as much again for what follows from the counts, and 192 MiB for the
/// program and one chunk. Time: at least a second beyond the time that has passed, and one more
/// second for every 32 MiB. The library inflates 200 MiB in a second.
fn grant(claimed: u64) {
    let Some(start) = CONFINED.get() else { return };
    // The processor has spent less time here than the clock shows.
    let seconds = start.elapsed().as_secs() + 2 + (claimed >> 25);
    limits::set((192 << 20) + claimed + claimed / 2, seconds);
}
