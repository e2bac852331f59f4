//! How much work a bake is, and on how many threads.

use crate::plan::default;
use crate::plan::error::PlanError;
use crate::plan::limits::RAYS_PER_RANDOMISATION;
use crate::plan::number::{count, positive};
use crate::plan::request::Request;
use std::num::NonZeroUsize;
use tables::MOST_SHARDS;
use tables::options::Sampler;

/// How much work to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Effort {
    /// That many rays per direction.
    Rays(u64),
    /// Rays until the estimated L1 error of every direction is below this.
    Tolerance(f64),
}

/// An equal share of the samples of a bake.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Shard {
    /// Which one, from 1.
    pub number: u32,
    /// How many there are, at least 2.
    pub of: u32,
}

/// Threads at most.
const MOST_THREADS: usize = 4096;

impl Effort {
    /// What `--rays` and `--tolerance` ask for.
    pub(crate) fn of(request: &Request) -> Result<Self, PlanError> {
        let both = |first, second| Err(PlanError::Both { first, second });
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
            return both("--rays", "--tolerance");
        }
        if request.shard.is_some() {
            return both("--tolerance", "--shard");
        }
        if request.sampler == Sampler::Random {
            return Err(PlanError::ToleranceSampler);
        }
        let range = "above 0 and at most 2, the greatest L1 distance";
        positive("--tolerance", tolerance, 2.0, range)?;
        Ok(Effort::Tolerance(tolerance))
    }

    /// Independent randomisations per direction.
    pub(crate) fn randomisations(self, sampler: Sampler) -> usize {
        match (sampler, self) {
            (Sampler::Random, _) => 1,
            (Sampler::Sobol, Effort::Rays(rays)) => rays.min(default::RANDOMISATIONS) as usize,
            (Sampler::Sobol, Effort::Tolerance(_)) => default::RANDOMISATIONS_TO_TOLERANCE as usize,
        }
    }
}

/// What `--threads` asks for.
pub(crate) fn threads(request: &Request) -> Result<Option<NonZeroUsize>, PlanError> {
    let checked = |threads: usize| {
        let wrong = PlanError::Count {
            option: "--threads",
            value: threads as u64,
            most: MOST_THREADS as u64,
        };
        NonZeroUsize::new(threads)
            .filter(|threads| threads.get() <= MOST_THREADS)
            .ok_or(wrong)
    };
    request.threads.map(checked).transpose()
}

/// What `--shard` asks for, such as `2/8`; the only share of one is the whole bake.
pub(crate) fn shard(request: &Request) -> Result<Option<Shard>, PlanError> {
    let Some(text) = request.shard.as_deref() else {
        return Ok(None);
    };
    let wrong = || PlanError::Shard { text: text.into() };
    let number = |part: &str| part.trim().parse::<u32>().map_err(|_| wrong());
    let (k, n) = text.split_once('/').ok_or_else(wrong)?;
    let (k, n) = (number(k)?, number(n)?);
    if k < 1 || k > n || n > MOST_SHARDS {
        return Err(wrong());
    }
    Ok((n > 1).then_some(Shard { number: k, of: n }))
}
