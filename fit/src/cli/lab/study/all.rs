//! All campaigns of a study, in parallel.

use rayon::prelude::*;

use crate::cli::failure::Failure;
use crate::cli::host::Host;
use estimator::Error;
use lab::study::{Refused, refused};

/// Runs all campaigns in parallel. Returns their trials, and the refused campaigns by reason.
///
/// # Errors
/// Returns [`Failure::Stopped`] if the host stopped the study.
pub(super) fn run_all<T: Send>(
    campaigns: u64,
    pool: &rayon::ThreadPool,
    host: Host<'_>,
    run: impl Fn(u64) -> Result<T, Error> + Sync,
) -> Result<(Vec<T>, Vec<Refused>), Failure> {
    let all: Vec<_> = host.watch(campaigns, |goes_on| {
        pool.install(|| {
            let all = (0..campaigns).into_par_iter();
            let one = |index| {
                let trial = run(index);
                goes_on().then_some(trial)
            };
            all.map(one).while_some().collect()
        })
    })?;
    Ok(refused::part(all))
}
