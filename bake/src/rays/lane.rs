//! Lanes: the number of rays that go side by side, the values of each of them, choices and rounding
//! that vectors can do, and samples drawn lane by lane.

#![allow(
    clippy::needless_range_loop,
    reason = "the same lane of several arrays; iterators hide that"
)]

use crate::geometry::{FOURTH_REVERSED, Piece, Stream, centred, pascal, philox, scramble};
use tables::options::Sampler;

/// Number of rays that are traced side by side, the lanes of a vector.
///
/// It is large enough that the compiler keeps the loops over lanes and turns them into vectors.
/// With 16 or 32 lanes the compiler unrolls the loops first and shuffles, which is 2.5 times
/// slower. With 128 lanes tracing is 20 % slower.
pub(crate) const LANES: usize = 64;

/// Number for each lane.
pub(crate) type Reals = [f64; LANES];

/// Number in f32 for each lane.
pub(crate) type Singles = [f32; LANES];

/// Set of rays, one word for each lane; the user of the type defines the meaning of the bits.
pub(crate) type Mask = [u64; LANES];

/// Sets the values of the rays in `taken` to those of `new`.
///
/// The values are chosen by bit operations, because a branch for every lane halves the speed.
#[inline(always)]
pub(crate) fn choose(values: &mut Reals, new: &Reals, taken: &Mask) {
    for lane in 0..LANES {
        let chosen = ((taken[lane] as i64) >> 63) as u64;
        let value = (new[lane].to_bits() & chosen) | (values[lane].to_bits() & !chosen);
        values[lane] = f64::from_bits(value);
    }
}

/// Returns the lesser of two numbers by a single instruction; neither may be NaN.
#[inline(always)]
pub(crate) fn lesser<T: PartialOrd>(a: T, b: T) -> T {
    if a < b { a } else { b }
}

/// Returns the greater of two numbers by a single instruction; neither may be NaN.
#[inline(always)]
pub(crate) fn greater<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// Reduces numbers, a multiple of `WIDTH` and at least one, to one number by `choose`.
///
/// It takes `WIDTH` of them side by side, and then those: an order that vectors can keep.
#[inline(always)]
pub(crate) fn fold<const WIDTH: usize, T: Copy>(values: &[T], choose: impl Fn(T, T) -> T) -> T {
    let mut some = [values[0]; WIDTH];
    for chunk in values.chunks_exact(WIDTH) {
        for lane in 0..WIDTH {
            some[lane] = choose(chunk[lane], some[lane]);
        }
    }
    some.into_iter().fold(some[0], choose)
}

/// 2^52, which leaves the nearest integer in the low bits when it is added to a number of 0 to
/// 2^51.
pub(crate) const UNITS: f64 = 4_503_599_627_370_496.0;

/// Returns the greatest integer up to `value`, exact for values from 0 to 2^51.
///
/// A cast would saturate, and for that the compiler gives up vectors: the whole tracer is then 3
/// times slower.
#[inline(always)]
pub(crate) fn floor(value: f64) -> f64 {
    let nearest = (value + UNITS) - UNITS;
    nearest - if nearest > value { 1.0 } else { 0.0 }
}

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
/// The operations are those of [`crate::geometry::Launch::entry`], lane by lane.
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
/// [`crate::geometry::Launch::chance`].
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks integers, their neighbours below and above, and halves against the library's floor.
    #[test]
    fn floors_are_exact() {
        let mut cases = 0;
        for whole in [
            0.0,
            1.0,
            2.0,
            3.0,
            127.0,
            128.0,
            1e6,
            2.0_f64.powi(51) - 1.0,
        ] {
            for value in [
                whole,
                whole.next_up(),
                whole + 0.5,
                (whole + 1.0).next_down(),
            ] {
                assert_eq!(floor(value), value.floor(), "{value}");
                cases += 1;
            }
        }
        assert_eq!(cases, 32);
    }
}
