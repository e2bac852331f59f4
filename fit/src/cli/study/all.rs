//! All campaigns of a study, in parallel, with a bar.

use rayon::prelude::*;

use crate::cli::progress::Progress;
use crate::estimate::Error;
use crate::study::{Refused, refused};

/// Runs all campaigns in parallel. Returns their trials, and the refused campaigns by reason.
pub(super) fn run_all<T: Send>(
    campaigns: u64,
    pool: &rayon::ThreadPool,
    run: impl Fn(u64) -> Result<T, Error> + Sync,
) -> (Vec<T>, Vec<Refused>) {
    let progress = Progress::of(campaigns);
    let all: Vec<_> = pool.install(|| {
        let all = (0..campaigns).into_par_iter();
        let one = |index| {
            let trial = run(index);
            progress.step();
            trial
        };
        all.map(one).collect()
    });
    progress.done();
    refused::part(all)
}
