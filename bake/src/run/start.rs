//! Start of a process and its joining of the other processes of its bake.

use crate::run::ranks::{Alone, Ranks};
#[cfg(feature = "mpi")]
use crate::run::world::World;

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
