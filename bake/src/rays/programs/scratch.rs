//! Working memory of a run of programs: fates by lane, where rays are counted, and the part of a
//! program that rays of a small part of the entrance can need.

#![allow(
    clippy::needless_range_loop,
    reason = "the same lane of several arrays; iterators hide that"
)]

use crate::rays::accumulator::Bins;
use crate::rays::lane::{LANES, Mask, Reals, UNITS, floor};
use crate::rays::programs::program::{DEPTH, Program, Step};
use crate::rays::programs::region::{Affine, ROUNDING};
use glam::DVec2;
use tables::Fate;

/// Working memory that a run keeps from one vector of rays to the next.
pub(crate) struct Scratch<'a> {
    /// Bins of the shift.
    pub bins: &'a Bins,
    /// Rays that are left at each depth of the tree.
    pub left: [Mask; DEPTH],
    /// Number of rays that ended with each fate, per lane.
    pub ended: [Mask; Fate::ALL.len()],
    /// Counters of the bins, for each exit direction if these are recorded and counted, and then
    /// [`LANES`] slots for the rays that fall in no bin.
    pub histogram: &'a mut [u32],
    /// Counters of single rays, if exit directions are recorded and listed.
    pub list: Option<&'a mut Vec<u32>>,
}

/// Counts the rays of `back` in the bins of (u, v). With `RECORD` the counters of the exit
/// direction of a ray begin at `start`.
#[inline(always)]
pub(crate) fn scatter<const RECORD: bool>(
    [u, v, start]: [&Reals; 3],
    back: &Mask,
    work: &mut Scratch,
) {
    let end = work.bins.count as f64;
    let listed = RECORD && work.list.is_some();
    let size = if listed {
        0.0
    } else if RECORD {
        (work.histogram.len() - LANES) as f64
    } else {
        work.bins.len() as f64
    };
    let mut within: Mask = [0; LANES];
    for lane in 0..LANES {
        // The top bits say: u < end, v < end, u >= 0, v >= 0.
        let below = (u[lane] - end).to_bits() & (v[lane] - end).to_bits();
        within[lane] = back[lane] & below & !(u[lane].to_bits() | v[lane].to_bits());
    }
    for lane in 0..LANES {
        work.ended[Fate::Retroreflected as usize][lane] += within[lane] >> 63;
        work.ended[Fate::OutOfRange as usize][lane] += (back[lane] & !within[lane]) >> 63;
    }
    let mut at = [0_u64; LANES];
    for lane in 0..LANES {
        let bin = floor(v[lane]) * end + floor(u[lane]);
        let bin = if RECORD { bin + start[lane] } else { bin };
        // The other rays are counted in slots beyond the histogram, one slot per lane. This needs
        // no branch, and no two lanes wait for one slot.
        let slot = if within[lane] >> 63 == 1 {
            bin
        } else {
            size + SPILL[lane]
        };
        at[lane] = (slot + UNITS).to_bits() & 0xffff_ffff;
    }
    if let (true, Some(list)) = (listed, &mut work.list) {
        let mut inside = [0_u32; LANES];
        let mut count = 0;
        for lane in 0..LANES {
            inside[count] = at[lane] as u32;
            count += (within[lane] >> 63) as usize;
        }
        list.extend_from_slice(&inside[..count]);
        return;
    }
    for bin in at {
        work.histogram[bin as usize] += 1;
    }
}

/// Numbers of the slots, after the histogram, for the rays that fall in no bin.
const SPILL: Reals = {
    let mut slots = [0.0; LANES];
    let mut lane = 0;
    while lane < LANES {
        slots[lane] = lane as f64;
        lane += 1;
    }
    slots
};

/// Part of a program that rays from one small part of the entrance can need.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Excerpt {
    /// Steps that such rays can take.
    pub steps: Vec<Step>,
    /// Tests of these steps, without those that all such rays pass.
    pub tests: Vec<Affine>,
}

impl Excerpt {
    /// Takes the part of `program` for rays that enter in the convex hull of `corners`.
    pub(crate) fn refill(&mut self, program: &Program, corners: &[DVec2]) {
        self.steps.clear();
        self.tests.clear();
        // True where an earlier step of the node at that depth takes all its rays.
        let mut closed = [false; DEPTH];
        // Steps deeper than this follow a step that no ray takes.
        let mut skipped = usize::MAX;
        for step in &program.steps {
            if step.from > skipped {
                continue;
            }
            skipped = usize::MAX;
            let first = self.tests.len();
            let mut taken = !closed[step.from];
            for test in &program.tests[step.tests.0..step.tests.1] {
                let values = corners.iter().map(|&corner| test.at(corner));
                let (least, most) = values
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), value| {
                        (l.min(value), m.max(value))
                    });
                taken &= most > -ROUNDING;
                if least < ROUNDING {
                    self.tests.push(*test);
                }
            }
            if !taken {
                self.tests.truncate(first);
                skipped = step.from;
                continue;
            }
            closed[step.from] = self.tests.len() == first;
            closed[step.from + 1] = false;
            self.steps.push(Step {
                tests: (first, self.tests.len()),
                ..*step
            });
        }
    }
}
