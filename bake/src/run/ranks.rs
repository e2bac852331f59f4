//! The processes that share one bake: this one alone, or the ranks of MPI (feature `mpi`).
//!
//! Every rank makes the same steps: it traces its part of the samples, and now and then the integer counts of all are
//! added up in rank 0, which alone reads what was saved, prints and writes. What depends on time or on sums (when to save,
//! which directions are still open) rank 0 decides for all.

/// The processes of one bake, seen from one of them. What is called here all must call, in the same order.
pub trait Ranks {
    /// Number of this process, from 0.
    fn number(&self) -> usize;

    /// Processes in all.
    fn count(&self) -> usize;

    /// Adds up the numbers of all processes in rank 0; elsewhere they are 0 afterwards.
    fn gather(&self, numbers: &mut [u64]);

    /// Gives every process the numbers of rank 0.
    fn follow(&self, numbers: &mut [u64]);

    /// Ends this process and all others, with an exit code.
    fn abort(&self, code: u8) -> !;

    /// Whether this is rank 0.
    fn leads(&self) -> bool {
        self.number() == 0
    }

    /// The lowest rank that `failed`, known to all of them.
    fn first_of(&self, failed: bool) -> Option<usize> {
        let mut ranks = vec![0; self.count()];
        ranks[self.number()] = u64::from(failed);
        self.gather(&mut ranks);
        self.follow(&mut ranks);
        ranks.iter().position(|&failed| failed > 0)
    }
}

/// One process, which shares with none.
pub struct Alone;

impl Ranks for Alone {
    fn number(&self) -> usize {
        0
    }

    fn count(&self) -> usize {
        1
    }

    fn gather(&self, _: &mut [u64]) {}

    fn follow(&self, _: &mut [u64]) {}

    fn abort(&self, code: u8) -> ! {
        std::process::exit(code.into())
    }
}

/// A process that `mpirun` or `srun` started, by what they say in its environment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Launched {
    /// Number of the process, from 0.
    pub number: usize,
    /// Processes in all.
    pub count: usize,
}

impl Launched {
    /// Names of the variables for the rank and the number of ranks: those of Open MPI, then those of MPICH, Intel MPI and
    /// Slurm's own launcher.
    const VARIABLES: [(&str, &str); 2] = [
        ("OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"),
        ("PMI_RANK", "PMI_SIZE"),
    ];

    /// This process, by `variable` (of the environment); `None` if it was started by hand.
    pub fn from(variable: impl Fn(&str) -> Option<String>) -> Option<Self> {
        let number = |name| variable(name)?.parse().ok();
        Self::VARIABLES.iter().find_map(|(rank, size)| {
            let (number, count) = (number(rank)?, number(size)?);
            Some(Launched { number, count })
        })
    }
}

/// The ranks that this process was started among; itself alone where it was started by hand, or without the feature
/// `mpi`.
pub fn start(launched: Option<Launched>) -> Box<dyn Ranks> {
    #[cfg(feature = "mpi")]
    if let Some(world) = launched.and_then(|_| crate::run::world::World::start()) {
        return Box::new(world);
    }
    let _ = launched;
    Box::new(Alone)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn launchers_are_told_by_their_variables() {
        let of = |set: &[(&str, &str)]| {
            Launched::from(|name| {
                let found = set.iter().find(|(key, _)| *key == name);
                found.map(|(_, value)| value.to_string())
            })
        };
        let open_mpi = [("OMPI_COMM_WORLD_RANK", "2"), ("OMPI_COMM_WORLD_SIZE", "4")];
        let mpich = [("PMI_SIZE", "3"), ("PMI_RANK", "0")];
        let third = Launched {
            number: 2,
            count: 4,
        };
        assert_eq!(of(&open_mpi), Some(third));
        assert_eq!(
            of(&mpich),
            Some(Launched {
                number: 0,
                count: 3
            })
        );
        assert_eq!(of(&[open_mpi, mpich].concat()), Some(third));
        assert_eq!(of(&[]), None);
        assert_eq!(of(&mpich[..1]), None, "a rank without a number");
    }
}
