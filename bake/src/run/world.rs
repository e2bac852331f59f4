//! Ranks of MPI; this is the only file that names MPI.

use mpi::collective::{Root, SystemOperation};
use mpi::environment::Universe;
use mpi::topology::SimpleCommunicator;
use mpi::traits::Communicator;
use mpi::{Rank, Threading};

use crate::run::ranks::Ranks;

/// All processes that were started together.
pub(super) struct World {
    world: SimpleCommunicator,
    // When this is dropped, the process leaves the other ranks and waits until they leave too.
    _universe: Universe,
}

impl World {
    /// Joins the other processes, or returns `None` if this process has joined before.
    ///
    /// Only the thread that calls this function may use MPI.
    pub(super) fn start() -> Option<Self> {
        let (universe, _) = mpi::initialize_with_threading(Threading::Funneled)?;
        Some(World {
            world: universe.world(),
            _universe: universe,
        })
    }
}

impl Ranks for World {
    fn number(&self) -> usize {
        self.world.rank() as usize
    }

    fn count(&self) -> usize {
        self.world.size() as usize
    }

    fn gather(&self, numbers: &mut [u64]) {
        let leader = self.world.process_at_rank(LEADER);
        // MPI promises no order of the sum, but the order has no effect on integers.
        if self.leads() {
            let own = numbers.to_vec();
            leader.reduce_into_root(&own[..], numbers, SystemOperation::sum());
        } else {
            leader.reduce_into(&*numbers, SystemOperation::sum());
            numbers.fill(0);
        }
    }

    fn follow(&self, numbers: &mut [u64]) {
        self.world.process_at_rank(LEADER).broadcast_into(numbers);
    }

    fn abort(&self, code: u8) {
        self.world.abort(code.into())
    }
}

impl Drop for World {
    fn drop(&mut self) {
        // A rank that panics would wait for the others, while they wait for its counts.
        if std::thread::panicking() {
            self.abort(101);
        }
    }
}

const LEADER: Rank = 0;
