//! Runs a [`Program`] on 64 rays at a time, in plain Rust over arrays that the compiler vectorises.
//!
//! Everything here is inlined into one function per instruction set (see `simd`). Additions and
//! multiplications are rounded one by one. None is fused or reordered, so every instruction set
//! gives the same bits.
//!
//! A set of rays is a mask with one word per lane, of which only the top bit counts. The sign bit
//! of a test's value is then the mask of the rays that fail the test, and rays are taken and left
//! by bit operations.

#![allow(
    clippy::needless_range_loop,
    reason = "the same lane of several arrays; iterators hide that"
)]

use crate::geometry::{Launch, Stream};
use crate::rays::accumulator::Accumulator;
use crate::rays::accumulator::Bins;
use crate::rays::lane::order;
use crate::rays::lane::{LANES, Mask, Reals, choose};
use crate::rays::lane::{chances, digits, points, sobol};
use crate::rays::programs::exits::{ExitCounts, NumberedExits};
use crate::rays::programs::program::{DEPTH, End, Loss, Program, Step};
use crate::rays::programs::region::Affine;
use crate::rays::programs::scratch::Excerpt;
use crate::rays::programs::scratch::{Scratch, scatter};
use crate::rays::simd::{InstructionSet, Task};
use std::ops::Range;
use tables::Fate;
use tables::options::Sampler;

/// Number of bits of a cell along each side of the square: a block is traced in 2^4 x 2^4 cells.
const CELL_BITS: u32 = 4;

/// Smallest number of pieces of the entrance for which samples are sorted by piece.
///
/// Without sorting, each vector of rays would look at all pieces.
const SORTED_PIECES: usize = 12;

/// Number of samples of the smallest block that is traced cell by cell: two vectors per cell.
const BLOCK: u64 = (2 * LANES as u64) << (2 * CELL_BITS);

/// Samples to trace, and the programs that trace them.
pub(crate) struct Batch<'a> {
    /// Programs of the scenes that `launch` leads into.
    pub programs: &'a [Program],
    /// Map from samples to entry points.
    pub launch: &'a Launch,
    /// Bins of the accumulator.
    pub bins: &'a Bins,
    /// Stream that the samples come from.
    pub stream: &'a Stream,
    /// Indices of the samples.
    pub samples: Range<u64>,
    /// Exit directions to record; `None` if they are not recorded.
    pub exits: Option<&'a NumberedExits>,
}

/// Tracing of a batch, compiled for each kind of batch: the plain one has its registers for itself.
struct Tracing<'a, const RECORD: bool, const LOSSY: bool> {
    batch: &'a Batch<'a>,
    accumulator: &'a mut Accumulator,
}

impl<const RECORD: bool, const LOSSY: bool> Task for Tracing<'_, RECORD, LOSSY> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        run::<RECORD, LOSSY>(self.batch, self.accumulator);
    }
}

impl Batch<'_> {
    /// Traces all samples with these instructions and counts them in `accumulator`.
    pub(crate) fn trace(&self, instructions: InstructionSet, accumulator: &mut Accumulator) {
        let batch = self;
        // All programs of a scene have the same rules.
        let first = self.programs.first();
        let lossy = first.is_some_and(|program| program.entry.is_some());
        match (self.exits.is_some(), lossy) {
            (false, false) => instructions.run(Tracing::<false, false> { batch, accumulator }),
            (true, false) => instructions.run(Tracing::<true, false> { batch, accumulator }),
            (false, true) => instructions.run(Tracing::<false, true> { batch, accumulator }),
            (true, true) => instructions.run(Tracing::<true, true> { batch, accumulator }),
        }
    }
}

/// Traces all samples of a batch and counts them in `accumulator`. `RECORD` is true if the batch
/// has exit directions to record, `LOSSY` if its programs have losses.
#[inline(always)]
fn run<const RECORD: bool, const LOSSY: bool>(batch: &Batch, accumulator: &mut Accumulator) {
    let Batch {
        programs,
        launch,
        bins,
        stream,
        ref samples,
        exits,
    } = *batch;
    let rays = (samples.end - samples.start) as usize;
    let mut record = exits.map(|exits| exits.record(bins, rays));
    let programs = Programs { programs, exits };
    let (histogram, list) = match &mut record {
        None => (&mut accumulator.histogram[..], None),
        Some(ExitCounts::Counters(counters)) => (&mut counters[..], None),
        Some(ExitCounts::List(list)) => (&mut [][..], Some(list)),
    };
    let mut work = Scratch {
        bins,
        left: [[0; LANES]; DEPTH],
        ended: [[0; LANES]; Fate::ALL.len()],
        histogram,
        list,
    };
    let cells = stream.sampler == Sampler::Sobol;
    let mut first = samples.start;
    if sorts(launch) {
        // Photons carry their index along, because their chance depends on it.
        if LOSSY {
            by_pieces::<RECORD, LOSSY, 3>(programs, launch, stream, samples.clone(), &mut work);
        } else {
            by_pieces::<RECORD, LOSSY, 2>(programs, launch, stream, samples.clone(), &mut work);
        }
        first = samples.end;
    }
    while first < samples.end {
        // `aligned` is the size of the largest block of 2^k samples that starts at a multiple of
        // its size.
        let left = samples.end - first;
        let aligned = 1 << first.trailing_zeros().min(left.ilog2());
        if cells && aligned >= BLOCK {
            by_cells::<RECORD, LOSSY>(programs, launch, stream, first, aligned, &mut work);
            first += aligned;
        } else {
            let next = if cells {
                left.min(BLOCK - first % BLOCK)
            } else {
                left
            };
            in_order::<RECORD, LOSSY>(programs, launch, stream, first..first + next, &mut work);
            first += next;
        }
    }
    let ended = work.ended;
    if let (Some(exits), Some(record)) = (exits, &record) {
        exits.count(bins, record, accumulator);
    }
    for (sum, lanes) in accumulator.fates.iter_mut().zip(&ended) {
        *sum += lanes.iter().sum::<u64>();
    }
}

/// Traces samples in the order of their indices.
#[inline(always)]
fn in_order<const RECORD: bool, const LOSSY: bool>(
    programs: Programs,
    launch: &Launch,
    stream: &Stream,
    samples: Range<u64>,
    work: &mut Scratch,
) {
    let mut first = samples.start;
    while first < samples.end {
        let active = (samples.end - first).min(LANES as u64) as usize;
        let (a, b) = digits(stream, first);
        let mut chance = [0.0; LANES];
        if LOSSY {
            let mut indices = [0; LANES];
            for lane in 0..LANES {
                indices[lane] = first + lane as u64;
            }
            chance = chances(stream, &indices);
        }
        let mut started = [0; LANES];
        started[..active].fill(1 << 63);
        for piece in launch.pieces() {
            let (x, y, chosen) = points(piece, &a, &b);
            let mut start = started;
            for lane in 0..LANES {
                start[lane] &= chosen[lane];
            }
            let course = programs.whole(piece.scene);
            trace_lanes::<RECORD, LOSSY>(course, [&x, &y, &chance], start, work);
        }
        first += LANES as u64;
    }
}

/// Returns whether samples of `launch` are sorted by the piece that they choose.
pub(crate) fn sorts(launch: &Launch) -> bool {
    launch.pieces().len() >= SORTED_PIECES
}

/// Traces samples in the order of the pieces that they choose.
///
/// `WORDS` is the number of words of a sample: two digits and, with losses, its place among all
/// samples.
#[inline(always)]
fn by_pieces<const RECORD: bool, const LOSSY: bool, const WORDS: usize>(
    programs: Programs,
    launch: &Launch,
    stream: &Stream,
    samples: Range<u64>,
    work: &mut Scratch,
) {
    let mut drawn = Vec::with_capacity((samples.end - samples.start) as usize + LANES);
    for first in samples.clone().step_by(LANES) {
        let (a, b) = digits(stream, first);
        let place = (first - samples.start) as u32;
        drawn.extend((0..LANES).map(|lane| {
            let words = [a[lane], b[lane], place + lane as u32];
            let mut sample = [0; WORDS];
            sample.copy_from_slice(&words[..WORDS]);
            sample
        }));
    }
    drawn.truncate((samples.end - samples.start) as usize);
    // The first coordinate is cut into slots, 8 to 16 of them for a piece of the mean size. The
    // slots are so fine that few samples of a piece's slots choose a neighbouring piece. `points`
    // decides for each sample which piece it chooses.
    let bits = launch.pieces().len().ilog2() + 4;
    let slot = |of: &[u32; WORDS]| of[0] >> (32 - bits);
    let drawn = order(&drawn, 1 << bits, |sample| slot(sample) as usize);
    for piece in launch.pieces() {
        let [from, to] = [piece.from, piece.to].map(|end| (end * f64::from(1 << bits)) as u32);
        let from = drawn.partition_point(|sample| slot(sample) < from);
        let count = drawn[from..].partition_point(|sample| slot(sample) <= to);
        let course = programs.whole(piece.scene);
        for some in drawn[from..from + count].chunks(LANES) {
            let (mut a, mut b, mut indices) = ([0; LANES], [0; LANES], [samples.start; LANES]);
            for (lane, sample) in some.iter().enumerate() {
                (a[lane], b[lane]) = (sample[0], sample[1]);
                if LOSSY {
                    indices[lane] += u64::from(sample[2]);
                }
            }
            let (x, y, mut start) = points(piece, &a, &b);
            start[some.len()..].fill(0);
            let chance = if LOSSY {
                chances(stream, &indices)
            } else {
                [0.0; LANES]
            };
            trace_lanes::<RECORD, LOSSY>(course, [&x, &y, &chance], start, work);
        }
    }
}

/// Traces an aligned block of 2^k Sobol samples cell by cell of the unit square.
///
/// Rays of one cell need few of the program's steps and tests, and their shifts fall in few bins.
///
/// A cell fixes the first four digits of both coordinates. Scrambling maps cells onto cells. Before
/// scrambling, these digits of the first coordinate are the lowest four bits of the index. Those of
/// the second coordinate are a function of the exclusive or of all groups of four bits of the
/// index; this function is the Pascal matrix of four digits.
#[inline(always)]
fn by_cells<const RECORD: bool, const LOSSY: bool>(
    programs: Programs,
    launch: &Launch,
    stream: &Stream,
    first: u64,
    count: u64,
    work: &mut Scratch,
) {
    let base = (first >> (2 * CELL_BITS)) as u32;
    let mut excerpt = Excerpt::default();
    let (mut corners, mut points_of_cell) = (Vec::new(), Vec::new());
    for cell in 0..1_u32 << (2 * CELL_BITS) {
        let (low, sum) = (cell & 15, cell >> 4);
        let index = |high: u32| {
            let mut folded = high ^ (high >> 16);
            folded ^= folded >> 8;
            folded ^= folded >> 4;
            (high << 8) | (((sum ^ low ^ folded) & 15) << 4) | low
        };
        let digits = stream
            .pair(u64::from(index(base)))
            .map(|digits| f64::from(digits >> (32 - CELL_BITS)));
        for piece in launch.pieces() {
            // Only a part of the cell chooses this piece.
            let (from, to) = (digits[0] / 16.0, (digits[0] + 1.0) / 16.0);
            let (from, to) = (from.max(piece.from), to.min(piece.to));
            if from >= to {
                continue;
            }
            let [from, to] = [from, to].map(|along| piece.stretched(along - 0.5));
            let [low, high] = [digits[1], digits[1] + 1.0].map(|end| end / 16.0 - 0.5);
            corners.clear();
            corners.extend([(from, low), (to, low), (from, high), (to, high)]);
            if piece.folded {
                // The part beyond the diagonal is folded back over it. So the points where the
                // diagonal crosses the sides are corners too.
                let crossings = [(from, -from), (to, -to), (-low, low), (-high, high)];
                let on_side =
                    |&(c0, c1): &(f64, f64)| from <= c0 && c0 <= to && low <= c1 && c1 <= high;
                corners.extend(crossings.iter().filter(|end| on_side(end)));
            }
            let program = &programs.programs[piece.scene];
            points_of_cell.clear();
            points_of_cell.extend(corners.iter().map(|&(c0, c1)| piece.point(c0, c1)));
            excerpt.refill(program, &points_of_cell);
            let mut maps = excerpt.steps.iter().filter_map(|step| match step.end {
                End::Shift(map) => Some(map),
                _ => None,
            });
            let map = maps.next();
            let map = if maps.all(|other| Some(other) == map) {
                map
            } else {
                None
            };
            let course = Passage {
                steps: &excerpt.steps,
                tests: &excerpt.tests,
                maps: &program.maps,
                starts: programs.starts(piece.scene),
                entry: program.entry.as_ref(),
                only: map,
            };
            for group in 0..(count >> (2 * CELL_BITS)) as u32 / LANES as u32 {
                let mut indices = [0_u32; LANES];
                for lane in 0..LANES {
                    indices[lane] = index(base + group * LANES as u32 + lane as u32);
                }
                let mut chance = [0.0; LANES];
                if LOSSY {
                    chance = chances(stream, &indices.map(u64::from));
                }
                let (a, b) = sobol(stream, &indices);
                let (x, y, start) = points(piece, &a, &b);
                trace_lanes::<RECORD, LOSSY>(course, [&x, &y, &chance], start, work);
            }
        }
    }
}

/// Steps and tests that a vector of rays goes through.
#[derive(Clone, Copy)]
struct Passage<'a> {
    steps: &'a [Step],
    tests: &'a [Affine],
    maps: &'a [[Affine; 2]],
    /// First counter of the exit direction of each map; empty if exit directions are not recorded.
    starts: &'a [f64],
    /// Loss on the way in.
    entry: Option<&'a Loss>,
    /// Number of the only map of these steps; `None` if there are several or none.
    only: Option<usize>,
}

/// Programs of the scenes, with the exit directions to record.
#[derive(Clone, Copy)]
struct Programs<'a> {
    programs: &'a [Program],
    exits: Option<&'a NumberedExits>,
}

impl<'a> Programs<'a> {
    /// Returns the first counters of the maps of a scene's program, none if exit directions are not
    /// recorded.
    #[inline(always)]
    fn starts(&self, scene: usize) -> &'a [f64] {
        self.exits.map_or(&[], |exits| exits.starts(scene))
    }

    /// Returns all steps and tests of a scene's program.
    #[inline(always)]
    fn whole(&self, scene: usize) -> Passage<'a> {
        let Program {
            steps,
            tests,
            maps,
            entry,
            ..
        } = &self.programs[scene];
        Passage {
            steps,
            tests,
            maps,
            starts: self.starts(scene),
            entry: entry.as_ref(),
            only: (maps.len() == 1).then_some(0),
        }
    }
}

/// Traces one vector of rays that enter at (x, y) and have these chances; only the rays in `start`
/// count.
#[inline(always)]
fn trace_lanes<const RECORD: bool, const LOSSY: bool>(
    course: Passage,
    [x, y, chance]: [&Reals; 3],
    start: Mask,
    work: &mut Scratch,
) {
    let Passage {
        steps,
        tests,
        maps,
        starts,
        entry,
        only,
    } = course;
    let left = &mut work.left;
    left[0] = match entry {
        Some(loss) if LOSSY => survivors(loss, chance, &start, &mut work.ended),
        _ => start,
    };
    // The bin positions of the rays that come back, and a mask of these rays.
    let (mut u, mut v): (Reals, Reals) = ([0.0; LANES], [0.0; LANES]);
    // The first counter of the exit direction of each ray.
    let mut start: Reals = [0.0; LANES];
    let mut back: Mask = [0; LANES];
    let mut returns = false;
    for step in steps {
        let from = step.from;
        let mut taken = left[from];
        let (first, last) = step.tests;
        if first < last {
            let mut failed: Mask = [0; LANES];
            for test in &tests[first..last] {
                let value = affine(test, x, y);
                for lane in 0..LANES {
                    failed[lane] |= value[lane].to_bits();
                }
            }
            for lane in 0..LANES {
                taken[lane] &= !failed[lane];
                left[from][lane] &= failed[lane];
            }
        }
        if let (true, Some(loss)) = (LOSSY, &step.loss) {
            taken = survivors(loss, chance, &taken, &mut work.ended);
        }
        match step.end {
            End::Onward => left[from + 1] = taken,
            End::Fate(fate) => {
                for lane in 0..LANES {
                    work.ended[fate as usize][lane] += taken[lane] >> 63;
                }
            }
            End::Shift(map) => {
                returns = true;
                for lane in 0..LANES {
                    back[lane] |= taken[lane];
                }
                if only.is_none() {
                    let [along, across] = &maps[map];
                    let (mu, mv) = (affine(along, x, y), affine(across, x, y));
                    choose(&mut u, &mu, &taken);
                    choose(&mut v, &mv, &taken);
                    if RECORD {
                        choose(&mut start, &[starts[map]; LANES], &taken);
                    }
                }
            }
        }
    }
    if !returns {
        return;
    }
    if let Some(map) = only {
        let [along, across] = &maps[map];
        (u, v) = (affine(along, x, y), affine(across, x, y));
        if RECORD {
            start = [starts[map]; LANES];
        }
    }
    scatter::<RECORD>([&u, &v, &start], &back, work);
}

/// Returns the photons of `taken` that a loss leaves, and counts the fate of the others.
#[inline(always)]
fn survivors(loss: &Loss, chance: &Reals, taken: &Mask, ended: &mut [Mask]) -> Mask {
    let mut kept: Mask = [0; LANES];
    let lost = &mut ended[loss.fate as usize];
    for lane in 0..LANES {
        // The top bit says: chance < power.
        kept[lane] = taken[lane] & (chance[lane] - loss.power).to_bits();
        lost[lane] += (taken[lane] & !kept[lane]) >> 63;
    }
    kept
}

/// Evaluates an affine function at the points (x, y) of all lanes.
#[inline(always)]
fn affine(function: &Affine, x: &Reals, y: &Reals) -> Reals {
    let mut value = [0.0; LANES];
    for lane in 0..LANES {
        value[lane] = function.x * x[lane] + function.y * y[lane] + function.one;
    }
    value
}
