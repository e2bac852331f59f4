//! Samples drawn side by side: their digits and entry points, lane by lane.

#![allow(
    clippy::needless_range_loop,
    reason = "the same lane of several arrays; iterators hide that"
)]

use crate::rays::lane::{LANES, Mask, Reals};
use crate::samples::{FOURTH_REVERSED, Piece, Stream, centred, pascal, philox, scramble};
use tables::options::Sampler;

/// Returns the digits of samples `first..first + LANES`, equal to those of [`Stream::pair`].
#[inline(always)]
pub(crate) fn digits(stream: &Stream, first: u64) -> ([u32; LANES], [u32; LANES]) {
    match stream.sampler {
        Sampler::Sobol => {
            let mut indices = [0_u32; LANES];
            for lane in 0..LANES {
                indices[lane] = (first as u32).wrapping_add(lane as u32);
            }
            sobol(stream, &indices)
        }
        Sampler::Random => {
            let (mut low, mut high) = ([0; LANES], [0; LANES]);
            for lane in 0..LANES {
                let index = first + lane as u64;
                [low[lane], high[lane]] = stream.counter(index).map(u64::from);
            }
            philox(&mut low, &mut high, stream.keys[0]);
            (words(&low), words(&high))
        }
    }
}

/// Returns the low words of all lanes.
#[inline(always)]
fn words(lanes: &Mask) -> [u32; LANES] {
    let mut words = [0; LANES];
    for lane in 0..LANES {
        words[lane] = lanes[lane] as u32;
    }
    words
}

/// Returns the digits of the Sobol samples with these `indices`.
#[inline(always)]
pub(crate) fn sobol(stream: &Stream, indices: &[u32; LANES]) -> ([u32; LANES], [u32; LANES]) {
    let (mut a, mut b) = ([0_u32; LANES], [0_u32; LANES]);
    for lane in 0..LANES {
        a[lane] = scramble(indices[lane], stream.keys[0]);
        b[lane] = scramble(pascal(indices[lane]), stream.keys[1]);
    }
    (a, b)
}

/// Returns the entry points in `piece`, and a mask of the rays that choose the piece.
///
/// The operations are those of [`crate::samples::Launch::entry`], lane by lane.
#[inline(always)]
pub(crate) fn points(piece: &Piece, a: &[u32; LANES], b: &[u32; LANES]) -> (Reals, Reals, Mask) {
    let (mut c0, mut c1): (Reals, Reals) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        c0[lane] = centred(a[lane]);
    }
    for lane in 0..LANES {
        c1[lane] = centred(b[lane]);
    }
    let mut chosen: Mask = [1 << 63; LANES];
    if !piece.takes_all() {
        for lane in 0..LANES {
            let along = c0[lane] + 0.5;
            // The top bits say: along < to, along >= from.
            chosen[lane] = (along - piece.to).to_bits() & !(along - piece.from).to_bits();
            c0[lane] = piece.stretched(c0[lane]);
        }
    }
    // Into new lists. In place, the compiler would store the changed lanes alone, which takes many
    // processors dozens of cycles.
    let (mut i, mut j) = (c0, c1);
    if piece.folded {
        for lane in 0..LANES {
            let flip = c0[lane] + c1[lane] > 0.0;
            i[lane] = if flip { -c1[lane] } else { c0[lane] };
            j[lane] = if flip { -c0[lane] } else { c1[lane] };
        }
    }
    let [s, t] = piece.sides;
    let (mut x, mut y): (Reals, Reals) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        x[lane] = piece.centre.x + (s.x * i[lane] + t.x * j[lane]);
    }
    for lane in 0..LANES {
        y[lane] = piece.centre.y + (s.y * i[lane] + t.y * j[lane]);
    }
    (x, y, chosen)
}

/// Returns the chances of the samples with these `indices`, equal to those of
/// [`crate::samples::Launch::chance`].
#[inline(always)]
pub(crate) fn chances(stream: &Stream, indices: &[u64; LANES]) -> Reals {
    let mut digits = [0_u32; LANES];
    match stream.sampler {
        Sampler::Sobol => {
            for (bit, column) in FOURTH_REVERSED.iter().enumerate() {
                for lane in 0..LANES {
                    let one = (indices[lane] as u32 >> bit) & 1;
                    digits[lane] ^= column & 0_u32.wrapping_sub(one);
                }
            }
            for lane in 0..LANES {
                digits[lane] = scramble(digits[lane], stream.keys[3]);
            }
        }
        Sampler::Random => {
            let (mut low, mut high) = ([0; LANES], [0; LANES]);
            for lane in 0..LANES {
                [low[lane], high[lane]] = stream.second_counter(indices[lane]).map(u64::from);
            }
            philox(&mut low, &mut high, stream.keys[0]);
            digits = words(&high);
        }
    }
    let mut chances = [0.0; LANES];
    for lane in 0..LANES {
        chances[lane] = centred(digits[lane]) + 0.5;
    }
    chances
}

/// Sorts `items` by their keys, which are below `keys`, at most 2^32.
///
/// It counts the items of each key and then puts every item in its place. Items with the same key
/// stay in their order.
pub(crate) fn order<T: Copy>(items: &[T], keys: usize, key: impl Fn(&T) -> usize) -> Vec<T> {
    let keys_of_items: Vec<u32> = items.iter().map(|item| key(item) as u32).collect();
    let mut next = vec![0_u32; keys + 1];
    for &key in &keys_of_items {
        next[key as usize + 1] += 1;
    }
    for key in 1..next.len() {
        next[key] += next[key - 1];
    }
    let mut ordered = items.to_vec();
    for (item, key) in items.iter().zip(keys_of_items) {
        let place = &mut next[key as usize];
        ordered[*place as usize] = *item;
        *place += 1;
    }
    ordered
}
