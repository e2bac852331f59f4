//! Number of rays, threads and shards of a bake, and checks of numbers against their ranges.

use crate::error::Error;
use crate::plan::default;
use crate::plan::request::Request;
use std::num::NonZeroUsize;
use tables::MOST_SHARDS;
use tables::options::Sampler;

/// Amount of work for each direction of a bake.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Effort {
    /// Fixed number of rays per direction.
    Rays(u64),
    /// Estimated L1 error at which the rays of a direction are enough.
    Tolerance(f64),
}

/// One of several equal parts of the samples of a bake.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Shard {
    /// Number of this part, from 1.
    pub number: u32,
    /// Number of parts, at least 2.
    pub of: u32,
}

/// Largest number of threads.
pub(crate) const MOST_THREADS: usize = 4096;

impl Effort {
    /// Reads the amount of work from `--rays` and `--tolerance`.
    pub(crate) fn of(request: &Request) -> Result<Self, Error> {
        let Some(tolerance) = request.tolerance else {
            let most = match request.sampler {
                Sampler::Sobol => RAYS_PER_RANDOMISATION * default::RANDOMISATIONS,
                Sampler::Random => 1 << 48,
            };
            let rays = request.rays.unwrap_or(default::RAYS);
            count("--rays", rays, most)?;
            return Ok(Effort::Rays(rays));
        };
        if request.rays.is_some() {
            return Err(Error::both("--rays", "--tolerance"));
        }
        if request.shard.is_some() {
            return Err(Error::both("--tolerance", "--shard"));
        }
        if request.sampler == Sampler::Random {
            return Err(Error::Usage(
                "--tolerance needs --sampler sobol, whose error is estimated from independent \
                randomisations; leave out --sampler random, or give --rays"
                    .into(),
            ));
        }
        // A hundred million rays reach some 1e-6 where they meet all bins; below, no bake ends.
        let allowed = (1e-7..=2.0).contains(&tolerance);
        let range = "from 1e-7 to 2, the greatest L1 distance";
        number("--tolerance", tolerance, allowed, range)?;
        Ok(Effort::Tolerance(tolerance))
    }

    /// Returns the number of independent randomisations per direction.
    pub(crate) fn randomisations(self, sampler: Sampler) -> usize {
        match (sampler, self) {
            (Sampler::Random, _) => 1,
            (Sampler::Sobol, Effort::Rays(rays)) => rays.min(default::RANDOMISATIONS) as usize,
            (Sampler::Sobol, Effort::Tolerance(_)) => default::RANDOMISATIONS_TO_TOLERANCE as usize,
        }
    }
}

/// Reads the number of threads from `--threads`; `None` stands for all processors.
pub(crate) fn threads(request: &Request) -> Result<Option<NonZeroUsize>, Error> {
    let Some(threads) = request.threads else {
        return Ok(None);
    };
    count("--threads", threads as u64, MOST_THREADS as u64)?;
    Ok(NonZeroUsize::new(threads))
}

/// Reads a part such as `2/8` from `--shard`; `None` stands for the whole bake, as does `1/1`.
pub(crate) fn shard(request: &Request) -> Result<Option<Shard>, Error> {
    let Some(text) = request.shard.as_deref() else {
        return Ok(None);
    };
    let wrong = || {
        Error::Usage(format!(
            "--shard {text}: give K/N, share K of N, such as 2/8, with N at most {MOST_SHARDS}"
        ))
    };
    let number = |part: &str| part.trim().parse::<u32>().map_err(|_| wrong());
    let (k, n) = text.split_once('/').ok_or_else(wrong)?;
    let (k, n) = (number(k)?, number(n)?);
    if k < 1 || k > n || n > MOST_SHARDS {
        return Err(wrong());
    }
    Ok((n > 1).then_some(Shard { number: k, of: n }))
}

/// Refuses a number that is not `allowed`; `range` says in words what is.
pub(crate) fn number(option: &str, value: f64, allowed: bool, range: &str) -> Result<(), Error> {
    match allowed {
        true => Ok(()),
        false => Err(Error::Usage(format!(
            "{option} {value}: give a number {range}"
        ))),
    }
}

/// Checks that a number is above 0 and at most `most`; `range` says so in words.
pub(crate) fn positive(option: &str, value: f64, most: f64, range: &str) -> Result<(), Error> {
    number(option, value, value > 0.0 && value <= most, range)
}

/// Checks that a whole number is from 1 to `most`.
pub(crate) fn count(option: &str, value: u64, most: u64) -> Result<(), Error> {
    if (1..=most).contains(&value) {
        return Ok(());
    }
    let range = format!("give a whole number from 1 to {most}");
    Err(Error::Usage(format!("{option} {value}: {range}")))
}

/// Largest number of rays of a direction in one randomisation.
///
/// A scrambled sequence has no more distinct points.
pub(crate) const RAYS_PER_RANDOMISATION: u64 = 1 << 32;

/// Largest number of bins along an axis.
pub(crate) const BINS_LIMIT: usize = 4096;

/// Largest array of a table, bytes. A table with a larger one could not be read again.
pub(crate) const MOST_BYTES: u64 = 1 << 31;
