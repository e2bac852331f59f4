//! Threads of a bake.

use crate::plan::Plan;
use crate::run::error::RunError;

/// As many threads as planned.
///
/// # Errors
/// [`RunError::Threads`].
pub(crate) fn pool(plan: &Plan) -> Result<rayon::ThreadPool, RunError> {
    let threads = plan.threads.map_or(0, |threads| threads.get());
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|source| RunError::Threads { threads, source })
}
