//! Pool of threads of the size that the user asks for.

use std::num::NonZeroUsize;

use crate::error::Error;

/// Largest number of threads: more than any machine has processors for.
const MOST_THREADS: usize = 4096;

/// Starts a pool of `threads` threads, or of one thread per core.
///
/// # Errors
/// Returns [`Error::Threads`] if the system does not start them.
pub fn pool(threads: Option<NonZeroUsize>) -> Result<rayon::ThreadPool, Error> {
    let threads = threads.map_or(0, NonZeroUsize::get);
    let failed = |reason| Error::Threads { threads, reason };
    if threads > MOST_THREADS {
        return Err(failed(format!("{MOST_THREADS} are the most")));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().map_err(|error| failed(error.to_string()))
}
