//! What a file may cost: bytes of memory and seconds of the processor.
//!
//! Deflate packs zeros a thousandfold, so a small file may hold a large table, or claim one. Up to
//! [`FREE`] bytes every claim is met; above, the file must be a [`PACKED`]th of it, which tables of
//! a thousand rays a direction are.

use std::cell::Cell;
use std::path::Path;
use std::sync::OnceLock;
use std::time::Instant;

use crate::error::error::Error;
use crate::file::limits;

/// Bytes of content that any file may claim.
const FREE: u64 = 128 << 20;

/// Bytes of content above that, per byte of the file.
const PACKED: u64 = 256;

/// What the arrays of a file have claimed so far.
pub(crate) struct Ledger {
    file_bytes: u64,
    claimed: Cell<u64>,
}

impl Ledger {
    /// Of a file of that length.
    pub(crate) fn new(file_bytes: u64) -> Ledger {
        Ledger {
            file_bytes,
            claimed: Cell::new(0),
        }
    }

    /// Enters an array before memory is asked for.
    ///
    /// # Errors
    /// [`Error::Inflated`].
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

/// When the process became one that only reads a table.
static CONFINED: OnceLock<Instant> = OnceLock::new();

/// Makes this a process that only reads a table, and may be stopped.
pub(crate) fn reader() {
    let _ = CONFINED.set(Instant::now());
}

/// Limits what the HDF5 library may take in a process that only reads a table; nothing elsewhere.
pub(crate) fn confine() {
    grant(0);
}

/// The limits for `claimed` bytes of content: half as much again for what follows from the counts,
/// and 192 MiB for the program and one chunk; a second, and one more for every 32 MiB. The library
/// inflates 200 MiB in a second.
fn grant(claimed: u64) {
    let Some(start) = CONFINED.get() else { return };
    // More time has passed than the processor has spent here.
    let seconds = start.elapsed().as_secs() + 2 + (claimed >> 25);
    limits::set((192 << 20) + claimed + claimed / 2, seconds);
}
