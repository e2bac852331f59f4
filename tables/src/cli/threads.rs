//! Pool of threads of the size that the user asks for.

use std::num::NonZeroUsize;

/// Largest number of threads: more than any machine has processors for.
const MOST_THREADS: usize = 4096;

/// Error of threads that could not be started.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("--threads {threads}: the threads could not be started ({reason}); ask for fewer")]
pub struct NoThreads {
    /// Number of threads that were asked for; 0 for one per core.
    pub threads: usize,
    /// Reason that the thread library gives.
    pub reason: String,
}

/// Starts a pool of `threads` threads, or of one thread per core.
///
/// # Errors
/// Returns [`NoThreads`] if the system does not start them.
pub fn pool(threads: Option<NonZeroUsize>) -> Result<rayon::ThreadPool, NoThreads> {
    let threads = threads.map_or(0, NonZeroUsize::get);
    if threads > MOST_THREADS {
        return Err(NoThreads {
            threads,
            reason: format!("{MOST_THREADS} are the most"),
        });
    }
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| NoThreads {
            threads,
            reason: error.to_string(),
        })
}
