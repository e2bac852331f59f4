//! Exit directions of programs, counted by shift.
//!
//! All rays of a path leave in one direction. So a ray is counted by its bin of shift and by the
//! number of its exit direction, and nothing is sorted.

use crate::rays::bins::Bins;
use crate::rays::lane::LANES;
use crate::rays::program::Program;
use crate::rays::tally::Tally;
use tables::deviation::{Entry, Grid};

/// Largest number of counters of a run, 8 MB. More exit directions are counted ray by ray.
const MOST_COUNTERS: usize = 1 << 21;

/// Exit directions of the programs of a sheet, numbered.
pub(crate) struct Exits {
    grid: Grid,
    /// Place of each exit direction in the first cell of the grid.
    places: Vec<u64>,
    /// First counter of the exit direction of each map, by program.
    starts: Vec<Vec<f64>>,
}

impl Exits {
    /// Numbers the exit directions of `programs` on `grid`.
    ///
    /// Returns `None` if there are too many for the memory of a run.
    pub(crate) fn new(programs: &[Program], grid: &Grid, bins: &Bins) -> Option<Self> {
        let mut places = Vec::new();
        let mut starts = Vec::new();
        for program in programs {
            let of_map = program.deviations.iter().map(|off| {
                let place = grid.place([0, 0], [grid.bin(off.y), grid.bin(off.x)]);
                let known = places.iter().position(|&known| known == place);
                let number = known.unwrap_or_else(|| {
                    places.push(place);
                    places.len() - 1
                });
                (number * bins.len()) as f64
            });
            starts.push(of_map.collect());
            if places.len() * bins.len() > MOST_COUNTERS {
                return None;
            }
        }
        Some(Exits {
            grid: *grid,
            places,
            starts,
        })
    }

    /// Returns the first counter of each map of a program.
    #[inline(always)]
    pub(crate) fn starts(&self, program: usize) -> &[f64] {
        &self.starts[program]
    }

    /// Returns counters at 0: the bins of each exit direction, and [`LANES`] slots.
    pub(crate) fn counters(&self, bins: &Bins) -> Vec<u32> {
        vec![0; self.places.len() * bins.len() + LANES]
    }

    /// Adds the counters of a run to the bins and to the exit directions of `tally`.
    pub(crate) fn count(&self, bins: &Bins, counters: &[u32], tally: &mut Tally) {
        let (size, pool) = (bins.len(), bins.count / self.grid.cells);
        for bin in 0..size {
            let [v, u] = [bin / bins.count, bin % bins.count].map(|k| k / pool);
            let cell = self.grid.place([v, u], [0, 0]);
            for (number, place) in self.places.iter().enumerate() {
                let rays = counters[number * size + bin];
                if rays > 0 {
                    tally.histogram[bin] += rays;
                    tally.entries.push(Entry {
                        place: cell + place,
                        rays: u64::from(rays),
                    });
                }
            }
        }
    }
}
