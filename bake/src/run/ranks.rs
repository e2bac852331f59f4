//! Processes that share one bake: this one alone, or the ranks of MPI (feature `mpi`).
//!
//! Every rank makes the same steps. It traces its part of the samples. Now and then the integer
//! counts of all ranks are added up in rank 0. Rank 0 alone reads saved bakes, prints and writes.
//! Rank 0 also decides for all ranks whatever depends on time or on sums: when to save, and which
//! directions need more rays.

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
