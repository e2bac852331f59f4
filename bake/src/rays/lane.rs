//! Lanes: the number of rays that go side by side, the values of each of them, and choices and
//! rounding that vectors can do.

#![allow(
    clippy::needless_range_loop,
    reason = "the same lane of several arrays; iterators hide that"
)]

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
