//! The processes that share one bake: this one alone, or the ranks of MPI (feature `mpi`).
//!
//! Every rank makes the same steps: it traces its part of the samples, and now and then the integer
//! counts of all are added up in rank 0, which alone reads what was saved, prints and writes. What
//! depends on time or on sums (when to save, which directions are still open) rank 0 decides for
//! all.

/// The processes of one bake, seen from one of them. What is called here all must call, in the same
/// order.
pub(crate) trait Ranks {
    /// Number of this process, from 0.
    fn number(&self) -> usize;

    /// Processes in all.
    fn count(&self) -> usize;

    /// Adds up the numbers of all processes in rank 0; elsewhere they are 0 afterwards.
    fn gather(&self, numbers: &mut [u64]);

    /// Gives every process the numbers of rank 0.
    fn follow(&self, numbers: &mut [u64]);

    /// Ends all processes with an exit code, where there are others than this one.
    fn abort(&self, code: u8);

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
