//! Exit directions of programs, counted by shift.
//!
//! All rays of a path leave in one direction. So a ray is counted by its bin of shift and by the
//! number of its exit direction. Where there are few exit directions, each has a counter for each
//! bin, and nothing is sorted. Where there are many, the rays are listed.

use crate::rays::accumulator::Accumulator;
use crate::rays::accumulator::Bins;
use crate::rays::lane::LANES;
use crate::rays::programs::program::Program;
use std::collections::HashMap;
use tables::deviation::{Entry, Grid};

/// Largest number of counters of a run, 8 MB. With more exit directions the rays are listed.
const MOST_COUNTERS: usize = 1 << 21;

/// Exit directions of the programs of a sheet, numbered.
pub(crate) struct NumberedExits {
    grid: Grid,
    /// Place of each exit direction in the first cell of the grid.
    places: Vec<u64>,
    /// First counter of the exit direction of each map, by program.
    starts: Vec<Vec<f64>>,
}

impl NumberedExits {
    /// Numbers the exit directions of `programs` on `grid`.
    ///
    /// Returns `None` if 32 bits cannot number all bins of all exit directions.
    pub(crate) fn new(programs: &[Program], grid: &Grid, bins: &Bins) -> Option<Self> {
        let mut places = Vec::new();
        let mut numbers = HashMap::new();
        let mut starts = Vec::new();
        for program in programs {
            let of_map = program.deviations.iter().map(|off| {
                let place = grid.place([0, 0], [grid.bin(off.y), grid.bin(off.x)]);
                let number = *numbers.entry(place).or_insert_with(|| {
                    places.push(place);
                    places.len() - 1
                });
                (number * bins.len()) as f64
            });
            starts.push(of_map.collect());
        }
        u32::try_from(places.len() * bins.len()).ok()?;
        Some(NumberedExits {
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

    /// Returns an empty record of a run of so many rays.
    pub(crate) fn record(&self, bins: &Bins, rays: usize) -> ExitCounts {
        let counters = self.places.len() * bins.len();
        if counters > MOST_COUNTERS {
            ExitCounts::List(Vec::with_capacity(rays + LANES))
        } else {
            ExitCounts::Counters(vec![0; counters + LANES])
        }
    }

    /// Adds the record of a run to the bins and to the exit directions of `accumulator`.
    pub(crate) fn count(&self, bins: &Bins, record: &ExitCounts, accumulator: &mut Accumulator) {
        match record {
            ExitCounts::Counters(counters) => self.add_counters(bins, counters, accumulator),
            ExitCounts::List(list) => {
                let size = bins.len();
                accumulator.exits.reserve(list.len());
                for &counter in list {
                    let (number, bin) = (counter as usize / size, counter as usize % size);
                    accumulator.histogram[bin] += 1;
                    accumulator
                        .exits
                        .push(self.cell(bins, bin) + self.places[number]);
                }
            }
        }
    }

    /// Returns the place of exit direction 0 in the cell of the grid that holds a bin of shift.
    fn cell(&self, bins: &Bins, bin: usize) -> u64 {
        let pool = bins.count / self.grid.cells;
        let [v, u] = [bin / bins.count, bin % bins.count].map(|k| k / pool);
        self.grid.place([v, u], [0, 0])
    }

    /// Adds counters to the bins and to the exit directions of `accumulator`.
    fn add_counters(&self, bins: &Bins, counters: &[u32], accumulator: &mut Accumulator) {
        let size = bins.len();
        for bin in 0..size {
            let cell = self.cell(bins, bin);
            for (number, place) in self.places.iter().enumerate() {
                let rays = counters[number * size + bin];
                if rays > 0 {
                    accumulator.histogram[bin] += rays;
                    accumulator.entries.push(Entry {
                        place: cell + place,
                        rays: u64::from(rays),
                    });
                }
            }
        }
    }
}

/// Rays of a run, by bin of shift and exit direction.
///
/// Counter number e B + b is that of bin b and exit direction e, where B is the number of bins.
pub(crate) enum ExitCounts {
    /// Number of rays of each counter, and [`LANES`] slots for the rays that fall in no bin.
    Counters(Vec<u32>),
    /// Number of the counter of each ray.
    List(Vec<u32>),
}
