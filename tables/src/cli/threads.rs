//! A pool of threads of the size that was asked for.

use std::num::NonZeroUsize;

/// Threads that could not be started.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("--threads {threads}: the threads could not be started ({reason}); ask for fewer")]
pub struct NoThreads {
    /// How many were asked for; 0 for one a core.
    pub threads: usize,
    /// What the library says.
    pub reason: String,
}

/// Starts a pool of `threads` threads, or of one a core.
///
/// # Errors
/// [`NoThreads`] when the system refuses them.
pub fn pool(threads: Option<NonZeroUsize>) -> Result<rayon::ThreadPool, NoThreads> {
    let threads = threads.map_or(0, NonZeroUsize::get);
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| NoThreads {
            threads,
            reason: error.to_string(),
        })
}
