//! Points of the four-dimensional unit cube as functions of (seed, stream, index).
//!
//! - sobol: the first four dimensions of the Sobol sequence (Joe and Kuo 2008, new-joe-kuo-6),
//!   Owen-scrambled by the hash of Laine and Karras (2011) with the constants of Vegdahl (2021).
//!   Any 2^k points from a multiple of 2^k on are evenly spread in each pair of dimensions and in
//!   all four. In the first two dimensions, and in each single one, they are spread as evenly as
//!   possible.
//! - independent: a counter through the finaliser of SplitMix64. The published loop draws such
//!   points.

use serde::{Deserialize, Serialize};

/// Number of coordinates of a point.
pub const DIMENSIONS: usize = 4;

/// Spreading of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Sequence {
    /// Owen-scrambled Sobol points
    Sobol,
    /// Independent points
    Independent,
}

impl Sequence {
    /// Returns the name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Sequence::Sobol => "sobol",
            Sequence::Independent => "independent",
        }
    }
}

/// One independent randomisation of a sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Points {
    sequence: Sequence,
    key: u64,
}

impl Points {
    /// Makes the randomisation `stream` of `seed`. Another stream or another seed gives independent
    /// points.
    pub fn new(sequence: Sequence, seed: u64, stream: u64) -> Points {
        let key = mix(seed ^ mix(stream.wrapping_add(1)));
        Points { sequence, key }
    }

    /// Returns point `index`. Its coordinates are centres of the 2^32 equal cells of [0, 1), so
    /// none lies on an end.
    pub fn at(&self, index: u32) -> [f64; DIMENSIONS] {
        let cells = match self.sequence {
            Sequence::Sobol => {
                let digits = digits(index);
                std::array::from_fn(|d| scramble(digits[d], self.word(u64::MAX, d) as u32))
            }
            Sequence::Independent => {
                std::array::from_fn(|d| (self.word(u64::from(index), d) >> 32) as u32)
            }
        };
        cells.map(|cell: u32| (f64::from(cell) + 0.5) / 4_294_967_296.0)
    }

    /// Returns a random word for one dimension of one point.
    fn word(&self, index: u64, dimension: usize) -> u64 {
        mix(self.key ^ mix(index.wrapping_mul(DIMENSIONS as u64) + dimension as u64))
    }
}

/// Returns two independent normal numbers that are a function of a point of the unit cube.
///
/// They come from a hash of its digits, so they are independent of its coordinates and of those of
/// other points. A blur that needs them has the noise of independent samples.
pub fn normals(point: [f64; DIMENSIONS]) -> [f64; 2] {
    let word = |key: u64| {
        let digits = point.iter().map(|own| own.to_bits());
        digits.fold(mix(key), |word, own| mix(word ^ own))
    };
    // 53 bits, and never 0.
    let uniform = |key| ((word(key) >> 11) as f64 + 0.5) / (1_u64 << 53) as f64;
    let radius = (-2.0 * f64::ln(uniform(1))).sqrt();
    let (sine, cosine) = (std::f64::consts::TAU * uniform(2)).sin_cos();
    [radius * cosine, radius * sine]
}

/// Mixes 64 bits by a bijection (the finaliser of SplitMix64).
fn mix(word: u64) -> u64 {
    let word = word.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    word ^ (word >> 31)
}

/// Returns the digits of the plain Sobol point `index` in each dimension, with the first digit in
/// the lowest bit.
fn digits(index: u32) -> [u32; DIMENSIONS] {
    let mut digits = [index, 0, 0, 0];
    let mut left = index;
    while left != 0 {
        let bit = left.trailing_zeros() as usize;
        for (digits, columns) in digits[1..].iter_mut().zip(&COLUMNS) {
            *digits ^= columns[bit];
        }
        left &= left - 1;
    }
    digits
}

/// Applies Owen's scrambling to the point whose digits are the bits of `digits`, lowest bit first.
fn scramble(digits: u32, seed: u32) -> u32 {
    let mut x = digits;
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// Direction numbers of the dimensions after the first, with the first digit in the lowest bit.
const COLUMNS: [[u32; 32]; DIMENSIONS - 1] = [
    columns(&[1], 0),
    columns(&[1, 3], 1),
    columns(&[1, 3, 1], 1),
];

/// Computes the direction numbers of the polynomial whose inner coefficients are the bits of
/// `inner`, from the first numbers `m`.
const fn columns(m: &[u32], inner: u32) -> [u32; 32] {
    let degree = m.len();
    let mut columns = [0_u32; 32];
    let mut i = 0;
    while i < 32 {
        columns[i] = if i < degree {
            m[i] << (31 - i)
        } else {
            let mut value = columns[i - degree] ^ (columns[i - degree] >> degree);
            let mut k = 1;
            while k < degree {
                if (inner >> (degree - 1 - k)) & 1 == 1 {
                    value ^= columns[i - k];
                }
                k += 1;
            }
            value
        };
        i += 1;
    }
    let mut i = 0;
    while i < 32 {
        columns[i] = columns[i].reverse_bits();
        i += 1;
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with scipy.stats.qmc.Sobol(4, scramble=False, bits=32).random(8), put from
    /// Gray-code into natural order. The program of Joe and Kuo prints the same points.
    #[test]
    fn plain_points_are_those_of_joe_and_kuo() {
        let expected = [
            [0.0, 0.0, 0.0, 0.0],
            [0.5, 0.5, 0.5, 0.5],
            [0.25, 0.75, 0.75, 0.75],
            [0.75, 0.25, 0.25, 0.25],
            [0.125, 0.625, 0.375, 0.125],
            [0.625, 0.125, 0.875, 0.625],
            [0.375, 0.375, 0.625, 0.875],
            [0.875, 0.875, 0.125, 0.375],
        ];
        for (index, expected) in expected.iter().enumerate() {
            let point = digits(index as u32).map(|d| f64::from(d.reverse_bits()) / 4_294_967_296.0);
            assert_eq!(&point, expected, "point {index}");
        }
    }

    /// Checks that of 1024 consecutive points one lies in each elementary box of area 2^-10 in the
    /// first two dimensions, and in each interval of length 2^-10 in each dimension. Scrambling
    /// must keep this property.
    #[test]
    fn scrambled_points_are_a_net() {
        let points = Points::new(Sequence::Sobol, 7, 3);
        let cell = |x: f64, bits: u32| (x * f64::from(1_u32 << bits)) as usize;
        let block: Vec<_> = (5 * 1024..6 * 1024).map(|i| points.at(i)).collect();
        let mut boxes = 0;
        let mut one_each = |of: &dyn Fn(&[f64; 4]) -> usize| {
            let mut seen = [0_u32; 1024];
            block.iter().for_each(|point| seen[of(point)] += 1);
            assert!(seen.iter().all(|&count| count == 1));
            boxes += seen.len();
        };
        for columns in 0..=10 {
            one_each(&|p| (cell(p[0], columns) << (10 - columns)) + cell(p[1], 10 - columns));
        }
        for dimension in 0..DIMENSIONS {
            one_each(&|p| cell(p[dimension], 10));
        }
        assert_eq!(boxes, (11 + 4) * 1024);
    }

    /// Checks means and products of pairs of coordinates of independent points. They have the
    /// standard deviations sqrt(1/12n) and sqrt(7/144n). The tolerance is 5 of them for ten
    /// figures.
    #[test]
    fn independent_points_are_uncorrelated() {
        let points = Points::new(Sequence::Independent, 1, 0);
        let n = 100_000;
        let all: Vec<_> = (0..n).map(|i| points.at(i)).collect();
        let mean = |of: &dyn Fn(&[f64; 4]) -> f64| all.iter().map(of).sum::<f64>() / f64::from(n);
        let mut figures = 0;
        for i in 0..4 {
            assert!((mean(&|p| p[i]) - 0.5).abs() < 5.0 * (1.0 / 12.0 / f64::from(n)).sqrt());
            figures += 1;
            for k in i + 1..4 {
                let product = mean(&|p| p[i] * p[k]);
                assert!((product - 0.25).abs() < 5.0 * (7.0 / 144.0 / f64::from(n)).sqrt());
                figures += 1;
            }
        }
        assert_eq!(figures, 10);
    }
}
