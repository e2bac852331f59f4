//! Processes that share one bake: this one alone, or the ranks of MPI (feature `mpi`).
//!
//! Every rank makes the same steps. It traces its part of the samples. Now and then the integer
//! counts of all ranks are added up in rank 0. Rank 0 alone reads saved bakes, prints and writes.
//! Rank 0 also decides for all ranks whatever depends on time or on sums: when to save, and which
//! directions need more rays.

#[cfg(feature = "mpi")]
use crate::run::world::World;

use crate::error::Error;

/// Processes of one bake, seen from one of them.
///
/// If one process calls a function that communicates, all processes must call it, in the same
/// order.
pub(crate) trait Ranks {
    /// Returns the number of this process, from 0.
    fn number(&self) -> usize;

    /// Returns the number of processes.
    fn count(&self) -> usize;

    /// Adds up the numbers of all processes in rank 0; in the other ranks the numbers are 0
    /// afterwards.
    fn gather(&self, numbers: &mut [u64]);

    /// Gives every process the numbers of rank 0.
    fn follow(&self, numbers: &mut [u64]);

    /// Ends all processes with an exit code; without other processes it does nothing.
    fn abort(&self, code: u8);

    /// Returns whether this process is rank 0.
    fn leads(&self) -> bool {
        self.number() == 0
    }

    /// Returns the lowest rank that `failed`; all ranks get the same answer.
    fn first_of(&self, failed: bool) -> Option<usize> {
        let mut ranks = vec![0; self.count()];
        ranks[self.number()] = u64::from(failed);
        self.gather(&mut ranks);
        self.follow(&mut ranks);
        ranks.iter().position(|&failed| failed > 0)
    }
}

/// Returns what this rank has prepared, if all ranks have succeeded.
///
/// # Errors
/// Returns the rank's own failure in the lowest rank that failed, and [`Error::Elsewhere`] in all
/// others, so that the failure is printed once.
pub(crate) fn agreed<T>(ready: Result<T, Error>, ranks: &dyn Ranks) -> Result<T, Error> {
    match ranks.first_of(ready.is_err()) {
        Some(first) if first != ranks.number() => Err(Error::Elsewhere),
        _ => ready,
    }
}

/// Single process that shares its bake with no other.
pub(crate) struct Alone;

impl Ranks for Alone {
    fn number(&self) -> usize {
        0
    }

    fn count(&self) -> usize {
        1
    }

    fn gather(&self, _: &mut [u64]) {}

    fn follow(&self, _: &mut [u64]) {}

    fn abort(&self, _: u8) {}
}

/// Process that `mpirun` or `srun` started, as its environment says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Launched {
    /// Number of the process, from 0.
    pub number: usize,
    /// Number of processes.
    pub count: usize,
}

impl Launched {
    /// Names of the variables for the rank and the number of ranks: first those of Open MPI, then
    /// those of MPICH, Intel MPI and Slurm's own launcher.
    const VARIABLES: [(&str, &str); 2] = [
        ("OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"),
        ("PMI_RANK", "PMI_SIZE"),
    ];

    /// Reads the place of this process from the environment, or returns `None` if it was started by
    /// hand.
    ///
    /// `variable` returns the value of a variable of the environment.
    pub(crate) fn from(variable: impl Fn(&str) -> Option<String>) -> Option<Self> {
        let number = |name| variable(name)?.parse().ok();
        Self::VARIABLES.iter().find_map(|(rank, size)| {
            let (number, count) = (number(rank)?, number(size)?);
            Some(Launched { number, count })
        })
    }

    /// Checks that a process that was started with others has joined them.
    ///
    /// # Errors
    /// Returns [`Error::Usage`] in the first process if this program cannot join the others, and
    /// [`Error::Elsewhere`] in the others.
    pub(crate) fn check(launched: Option<Self>, ranks: &dyn Ranks) -> Result<(), Error> {
        match launched {
            Some(Launched { number: 0, count }) if ranks.count() == 1 && count > 1 => {
                Err(Error::Usage(format!(
                    "this is one of {count} processes of mpirun, but this bake was built without \
                    the feature mpi, or for another MPI, so each process would do the whole bake; \
                    build it with `cargo install --path bake --features mpi`, or give each process \
                    its own --shard"
                )))
            }
            Some(Launched { count, .. }) if ranks.count() == 1 && count > 1 => {
                Err(Error::Elsewhere)
            }
            _ => Ok(()),
        }
    }
}

/// Returns the ranks that this process was started among.
///
/// It is alone if it was started by hand, or without the feature `mpi`.
pub(crate) fn start(launched: Option<Launched>) -> Box<dyn Ranks> {
    #[cfg(feature = "mpi")]
    if let Some(world) = launched.and_then(|_| World::start()) {
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
