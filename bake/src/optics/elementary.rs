//! Elementary functions without branches, which the compiler turns into vectors.
//!
//! The functions of `libm` have branches and tables, so they go one number at a time. The functions
//! here are Taylor series on short intervals. Additions and multiplications are rounded one by one,
//! so all instruction sets give the same bits.

use std::f64::consts::{LN_2, SQRT_2, TAU};

/// Number of terms of the series of the logarithm.
///
/// |s| is at most 3 - 2 sqrt 2 = 0.1716 in it. The first term left out is s^20 / 21 of the sum,
/// which is 2.3e-17.
const TERMS: usize = 10;

/// 2^52 + 2^51, which leaves a small integer in the low bits when it is added to it.
const INTEGERS: f64 = 6_755_399_441_055_744.0;

/// Returns the natural logarithm of `x`, from 2^-60 to 1.
///
/// The error is at most 4 units in the last place of the result.
///
/// It is k ln 2 + ln m, with m between sqrt 1/2 and sqrt 2, and ln m = 2 artanh s for
/// s = (m - 1) / (m + 1).
#[inline(always)]
pub(crate) fn ln(x: f64) -> f64 {
    const LEAST: u64 = (SQRT_2 / 2.0).to_bits();
    const COEFFICIENTS: [f64; TERMS] = {
        let mut terms = [0.0; TERMS];
        let mut n = 0;
        while n < TERMS {
            terms[n] = 2.0 / (2 * n + 1) as f64;
            n += 1;
        }
        terms
    };
    // 64 more than k, so that it is not negative.
    let power = (x.to_bits() + (64 << 52) - LEAST) >> 52;
    let m = f64::from_bits(x.to_bits() + (64 << 52) - (power << 52));
    let k = f64::from_bits(INTEGERS.to_bits() + power) - (INTEGERS + 64.0);
    let s = (m - 1.0) / (m + 1.0);
    let square = s * s;
    let mut sum = COEFFICIENTS[TERMS - 1];
    let mut n = TERMS - 1;
    while n > 0 {
        n -= 1;
        sum = sum * square + COEFFICIENTS[n];
    }
    k * LN_2 + s * sum
}

/// Returns the sine and the cosine of the angle of `cell`: the middle of this part of a full turn
/// that is cut into 2^32 parts.
///
/// The errors are at most 2^-52.
///
/// The angle is taken from the nearest quarter of a turn, so it is at most pi / 4. The first terms
/// left out are below 5e-17.
#[inline(always)]
pub(crate) fn sin_cos(cell: u32) -> (f64, f64) {
    let quarter = cell.wrapping_add(1 << 29) >> 30;
    let off = cell.wrapping_sub(quarter << 30) as i32;
    let angle = (f64::from(off) + 0.5) * (TAU / 4_294_967_296.0);
    let square = angle * angle;
    let (mut sine, mut cosine) = (0.0, 0.0);
    let mut n = SINE.len();
    while n > 0 {
        n -= 1;
        sine = sine * square + SINE[n];
        cosine = cosine * square + COSINE[n];
    }
    let sine = angle + angle * square * sine;
    let cosine = 1.0 + square * cosine;
    let (first, second) = if quarter & 1 == 1 {
        (cosine, sine)
    } else {
        (sine, cosine)
    };
    let sign = |of: u32| u64::from(of >> 1 & 1) << 63;
    (
        f64::from_bits(first.to_bits() ^ sign(quarter)),
        f64::from_bits(second.to_bits() ^ sign(quarter + 1)),
    )
}

/// Coefficients of the series of the sine, from the third power on: -1/3!, 1/5!, ...
const SINE: [f64; 8] = series(1);

/// Coefficients of the series of the cosine, from the second power on: -1/2!, 1/4!, ...
const COSINE: [f64; 8] = series(0);

/// Returns (-1)^k / (2 k + `odd`)! for k = 1, 2, ...
const fn series(odd: u32) -> [f64; 8] {
    let mut terms = [0.0; 8];
    let mut factorial = 1.0;
    let mut k = 1;
    while k <= 8 {
        let last = 2 * k + odd;
        // Factorials up to 17! are below 2^53, so they are exact.
        factorial *= last as f64 * (last - 1) as f64;
        terms[k as usize - 1] = if k % 2 == 1 { -1.0 } else { 1.0 } / factorial;
        k += 1;
    }
    terms
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of 32 bits: the ends, the neighbours of all powers of two and of all eighths of the
    /// range, and a million spread over the range.
    fn cells() -> Vec<u32> {
        let mut cells = Vec::new();
        for power in 0..32_u32 {
            for off in [0_u32, 1, u32::MAX] {
                cells.push((1_u32 << power).wrapping_add(off));
                cells.push((power << 27).wrapping_add(off));
            }
        }
        // The golden ratio of 2^32 spreads multiples evenly.
        cells.extend((0..1_000_000_u32).map(|k| k.wrapping_mul(2_654_435_769)));
        cells
    }

    /// libm states an error below 1 unit, so 5 units between the two show an error of 4 at most.
    #[test]
    fn logarithms_are_those_of_libm_to_some_units() {
        let (mut worst, mut cases) = (0.0_f64, 0);
        let small = (1..=60).map(|power| (-f64::from(power)).exp2());
        let near = (1..=53).map(|power| 1.0 - (-f64::from(power)).exp2());
        let root = SQRT_2 / 2.0;
        let ends = [root, root.next_down(), root.next_up(), 1.0];
        let spread = cells()
            .into_iter()
            .map(|cell| (f64::from(cell) + 0.5) / 4_294_967_296.0);
        for x in small.chain(near).chain(ends).chain(spread) {
            let (ours, exact) = (ln(x), libm::log(x));
            let unit = exact.abs().next_up() - exact.abs();
            worst = worst.max((ours - exact).abs() / unit);
            cases += 1;
        }
        println!("{cases} logarithms, worst {worst} units of the last place");
        assert_eq!(cases, 60 + 53 + 4 + cells().len());
        assert!(worst <= 5.0, "{worst}");
    }

    /// The angle that libm gets is rounded to 2^-51 at most (angles up to 2 pi), in addition to the
    /// errors of both.
    #[test]
    fn sines_and_cosines_are_those_of_libm() {
        let (mut worst, mut cases) = (0.0_f64, 0);
        for cell in cells() {
            let (sine, cosine) = sin_cos(cell);
            let angle = (f64::from(cell) + 0.5) / 4_294_967_296.0 * TAU;
            let (s, c) = libm::sincos(angle);
            worst = worst.max((sine - s).abs()).max((cosine - c).abs());
            cases += 1;
        }
        println!("{cases} angles, worst {worst:e}");
        assert_eq!(cases, 1_000_192);
        assert!(worst <= 5.0 * f64::EPSILON, "{worst}");
    }
}
