//! A [`Program`] run by sixteen rays at a time, in plain Rust over arrays that the compiler turns into vectors.
//!
//! Everything here is inlined into one function per instruction set (see `simd`). Additions and multiplications are
//! rounded one by one, nothing is fused or reordered, so every instruction set gives the same bits.
//!
//! A set of rays is a mask per lane of which the top bit counts: the sign bit of a test's value is then the mask of
//! the rays that fail it, and taking and leaving rays are bit operations.

use crate::launch::Launch;
use crate::program::{Affine, DEPTH, End, Program};
use crate::sequence::{Sampler, Stream, centred, pascal, philox, scramble};
use crate::tally::{Bins, Tally};
use std::ops::Range;
use tables::Fate;

/// Rays of a bundle: two AVX-512 vectors of f64, four of AVX2. (Eight lanes: 15 % slower.)
pub const LANES: usize = 16;

type Reals = [f64; LANES];
type Mask = [u64; LANES];

/// Traces `samples` of `stream`.
#[inline(always)]
pub fn run(
    program: &Program,
    launch: &Launch,
    bins: &Bins,
    stream: &Stream,
    samples: Range<u64>,
    tally: &mut Tally,
) {
    let mut ended = [[0u64; LANES]; Fate::ALL.len()];
    let mut first = samples.start;
    while first < samples.end {
        let active = (samples.end - first).min(LANES as u64) as usize;
        let (x, y) = entries(launch, stream, first);
        let mut start = [0; LANES];
        start[..active].fill(1 << 63);
        bundle(program, bins, &x, &y, start, &mut ended, tally);
        first += LANES as u64;
    }
    for (sum, lanes) in tally.fates.iter_mut().zip(&ended) {
        *sum += lanes.iter().sum::<u64>();
    }
}

/// Traces one bundle of rays that enter at (x, y); those in `start` count.
#[inline(always)]
fn bundle(
    program: &Program,
    bins: &Bins,
    x: &Reals,
    y: &Reals,
    start: Mask,
    ended: &mut [Mask; Fate::ALL.len()],
    tally: &mut Tally,
) {
    let mut left = [[0u64; LANES]; DEPTH];
    left[0] = start;
    // Bin position of the rays that come back, and which they are.
    let (mut u, mut v): (Reals, Reals) = ([0.0; LANES], [0.0; LANES]);
    let mut back: Mask = [0; LANES];
    let one_map = program.maps.len() == 1;
    for step in &program.steps {
        let from = step.from;
        let mut taken = left[from];
        let (first, last) = step.tests;
        if first < last {
            let mut failed: Mask = [0; LANES];
            for test in &program.tests[first..last] {
                let value = affine(test, x, y);
                for lane in 0..LANES {
                    failed[lane] |= value[lane].to_bits();
                }
            }
            for lane in 0..LANES {
                taken[lane] = left[from][lane] & !failed[lane];
                left[from][lane] &= failed[lane];
            }
        }
        match step.end {
            End::Onward => left[from + 1] = taken,
            End::Fate(fate) => {
                for lane in 0..LANES {
                    ended[fate as usize][lane] += taken[lane] >> 63;
                }
            }
            End::Shift(map) => {
                for lane in 0..LANES {
                    back[lane] |= taken[lane];
                }
                if !one_map {
                    let [along, across] = &program.maps[map];
                    let (mu, mv) = (affine(along, x, y), affine(across, x, y));
                    for lane in 0..LANES {
                        let chosen = taken[lane] >> 63 == 1;
                        u[lane] = if chosen { mu[lane] } else { u[lane] };
                        v[lane] = if chosen { mv[lane] } else { v[lane] };
                    }
                }
            }
        }
    }
    if program.maps.is_empty() {
        return;
    }
    if one_map {
        let [along, across] = &program.maps[0];
        (u, v) = (affine(along, x, y), affine(across, x, y));
    }
    scatter(bins, &u, &v, &back, ended, tally);
}

/// Counts the rays of `back` in the bins of (u, v).
#[inline(always)]
fn scatter(
    bins: &Bins,
    u: &Reals,
    v: &Reals,
    back: &Mask,
    ended: &mut [Mask; Fate::ALL.len()],
    tally: &mut Tally,
) {
    let end = bins.count as f64;
    let size = bins.len() as u32;
    let mut at = [0u32; LANES];
    for lane in 0..LANES {
        // Top bits: u < end, v < end, u >= 0, v >= 0.
        let below = (u[lane] - end).to_bits() & (v[lane] - end).to_bits();
        let within = back[lane] & below & !(u[lane].to_bits() | v[lane].to_bits());
        ended[Fate::Retroreflected as usize][lane] += within >> 63;
        ended[Fate::OutOfRange as usize][lane] += (back[lane] & !within) >> 63;
        let bin = (v[lane] as i32 as u32)
            .wrapping_mul(bins.count as u32)
            .wrapping_add(u[lane] as i32 as u32);
        // The other rays count in slots beyond the histogram, one per lane: no branch, and no queue at one slot.
        at[lane] = if within >> 63 == 1 {
            bin
        } else {
            size + lane as u32
        };
    }
    for bin in at {
        tally.histogram[bin as usize] += 1;
    }
}

#[inline(always)]
fn affine(function: &Affine, x: &Reals, y: &Reals) -> Reals {
    let mut value = [0.0; LANES];
    for lane in 0..LANES {
        value[lane] = function.x * x[lane] + function.y * y[lane] + function.one;
    }
    value
}

/// Entry points of samples `first..first + LANES`: those of [`Launch::point`].
#[inline(always)]
fn entries(launch: &Launch, stream: &Stream, first: u64) -> (Reals, Reals) {
    let (mut x, mut y): (Reals, Reals) = ([0.0; LANES], [0.0; LANES]);
    let [piece] = launch.pieces() else {
        for lane in 0..LANES {
            let point = launch.point(stream, first + lane as u64);
            (x[lane], y[lane]) = (point.x, point.y);
        }
        return (x, y);
    };
    let (mut a, mut b) = ([0u32; LANES], [0u32; LANES]);
    match stream.sampler {
        Sampler::Sobol => {
            for lane in 0..LANES {
                let index = (first as u32).wrapping_add(lane as u32);
                a[lane] = scramble(index, stream.keys[0]);
                b[lane] = scramble(pascal(index), stream.keys[1]);
            }
        }
        Sampler::Random => {
            for lane in 0..LANES {
                let index = first + lane as u64;
                let counter = [index as u32, (index >> 32) as u32 ^ stream.keys[1]];
                [a[lane], b[lane]] = philox(counter, stream.keys[0]);
            }
        }
    }
    for lane in 0..LANES {
        let point = piece.point(centred(a[lane]), centred(b[lane]));
        (x[lane], y[lane]) = (point.x, point.y);
    }
    (x, y)
}
