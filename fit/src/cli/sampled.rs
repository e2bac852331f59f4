//! The options of a model by samples.

use crate::estimate::Candidates;
use crate::estimate::Kind;
use crate::samples::Sampling;
use crate::samples::Sequence;

/// Samples of a render.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct Samples {
    /// Samples per pixel of --forward render
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub samples: u32,
    /// Seed of the samples
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// How samples are spread
    #[arg(long, value_enum, default_value_t = Sequence::Sobol)]
    pub sequence: Sequence,
}

impl Samples {
    /// The samples that were asked for.
    pub(crate) fn sampling(&self) -> Sampling {
        Sampling {
            samples: self.samples as usize,
            seed: self.seed,
            sequence: self.sequence,
        }
    }
}

/// Leaves the candidates that have samples. Ends the program with a usage error where none is left,
/// or another loss was asked for than those of MTFs.
pub(crate) fn only(candidates: &mut Candidates, loss: Option<Kind>, verb: &'static str) {
    match candidates.clone().with_samples(loss) {
        Ok(left) => *candidates = left,
        Err(conflict) => clap::Command::new(verb)
            .error(clap::error::ErrorKind::ArgumentConflict, conflict)
            .exit(),
    }
}
