//! Limits of what a file may cost: bytes of memory and seconds, of the processor and of the clock.
//!
//! Deflate packs zeros a thousandfold, so a small file may hold a large table, or claim to. A file
//! may claim up to [`FREE`] bytes of content. Above that, the content may be at most [`PACKED`]
//! times as long as the file; tables of a thousand rays a direction are within this.

use std::time::Duration;

use rustix::process::{Resource, Signal, getrlimit};

/// Signal that ends a process that has used up its time (SIGXCPU).
pub(crate) const OUT_OF_TIME: i32 = Signal::XCPU.as_raw();

/// Returns the greatest length of a file that this process may write, bytes; `None` without a
/// limit.
pub(crate) fn longest_file() -> Option<u64> {
    getrlimit(Resource::Fsize).current
}

/// Greatest number of bytes that the arrays of one table may take in memory.
pub(crate) const MOST_BYTES: u64 = 1 << 31;

/// Number of bytes of content that any file may claim.
const FREE: u64 = 128 << 20;

/// Greatest ratio of claimed content to the length of the file, above [`FREE`].
const PACKED: u64 = 256;

/// Greatest content of any file, bytes: the largest counts, histogram and entries together.
const MOST_CONTENT: u64 = 6 << 30;

/// Returns the content that a file of this length may claim, bytes.
pub(crate) fn most_content(file_bytes: u64) -> u64 {
    file_bytes.saturating_mul(PACKED).clamp(FREE, MOST_CONTENT)
}

/// Returns the greatest time on the processor for a file of this length, seconds.
///
/// The start takes 5 seconds at most. A second is given for every 32 MiB of the file, which can be
/// hashed and searched more than twice in it, and for every 32 MiB of content, of which a second
/// inflates 200 MiB.
pub(crate) fn processor(file_bytes: u64, claimed: u64) -> u64 {
    5 + (file_bytes >> 25) + (claimed >> 25)
}

/// Returns how long anybody waits for a file of this length to be read.
///
/// The clock gets four times the processor's seconds, for machines that are busy, and half a
/// minute.
pub(crate) fn patience(file_bytes: u64) -> Duration {
    Duration::from_secs(30 + 4 * processor(file_bytes, most_content(file_bytes)))
}
