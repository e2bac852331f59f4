//! The options of a forward model that draws samples.

use tables::cli as terminal;

use crate::cli::failure::Failure;
use estimator::estimate::Candidates;
use estimator::estimate::Kind;
use estimator::samples::Sampling;
use estimator::samples::Sequence;

/// Samples of `--forward render`.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct Samples {
    /// Samples per pixel of --forward render.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 256,
        value_parser = terminal::whole::<u32>(1..=65_536),
        help_heading = "Forward model"
    )]
    pub samples: u32,
    /// Seed of the samples.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        help_heading = "Forward model",
        value_parser = terminal::whole::<u64>(0..)
    )]
    pub seed: u64,
    /// Sample sequence.
    ///
    /// Sobol points are spread more evenly than independent ones.
    #[arg(long, value_enum, default_value_t = Sequence::Sobol, help_heading = "Forward model")]
    pub sequence: Sequence,
}

impl Samples {
    /// Returns number, seed and sequence of the samples that were asked for.
    pub(crate) fn sampling(&self) -> Sampling {
        Sampling {
            samples: self.samples as usize,
            seed: self.seed,
            sequence: self.sequence,
        }
    }
}

/// Returns those of the candidates that have samples.
///
/// # Errors
/// Returns [`Failure::Usage`] if none is left, or if a loss was asked for that does not compare
/// MTFs.
pub(crate) fn only(
    candidates: Candidates,
    loss: Option<Kind>,
    verb: &'static str,
) -> Result<Candidates, Failure> {
    let left = candidates.with_samples(loss);
    left.map_err(|conflict| Failure::conflict(verb, conflict))
}
