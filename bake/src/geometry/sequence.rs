//! Points of the unit square as pure functions of (stream, index): plain random and
//! low-discrepancy.
//!
//! A **stream** is one independent randomisation for one direction. Coordinates are 32-bit
//! integers, read as the centres of 2^32 equal cells. So no sample falls on the end of the
//! interval, and means have no bias.
//!
//! - random: Philox2x32-10 (Salmon et al. 2011), a counter-based generator. Every index costs the
//!   same.
//! - sobol: the first four dimensions of the Sobol sequence (Joe and Kuo 2008), Owen-scrambled by
//!   the hash of Laine and Karras (2011) with the constants of Vegdahl (2021). Every 2^k points
//!   from a multiple of 2^k on are a (0, k, 2)-net in the first two dimensions.

use tables::options::Sampler;
/// One independent randomisation of the samples of one direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Stream {
    /// Method that spreads the points.
    pub sampler: Sampler,
    /// Scrambling seeds of the four dimensions (sobol) or key and counter tweak (random).
    pub keys: [u32; 4],
}

impl Stream {
    /// Creates stream number `randomisation` of the direction given by its angles in degrees, for
    /// `seed`.
    ///
    /// The stream depends on the angles themselves and not on their place in a list. So a direction
    /// has the same samples in every table that names it.
    pub(crate) fn new(
        sampler: Sampler,
        seed: u64,
        incidence_deg: f64,
        azimuth_deg: f64,
        randomisation: u64,
    ) -> Self {
        // Adding 0 turns -0 into 0, which is the same angle.
        let words = [
            (incidence_deg + 0.0).to_bits(),
            (azimuth_deg + 0.0).to_bits(),
            randomisation,
        ];
        let hash = words
            .iter()
            .fold(mix(seed), |hash, &word| mix(hash ^ mix(word)));
        let more = mix(hash ^ 0x5851_f42d_4c95_7f2d);
        Stream {
            sampler,
            keys: [
                hash as u32,
                (hash >> 32) as u32,
                more as u32,
                (more >> 32) as u32,
            ],
        }
    }

    /// Returns the first two coordinates of point `index`, as cells of [0, 1) cut in 2^32.
    #[inline]
    pub(crate) fn pair(&self, index: u64) -> [u32; 2] {
        match self.sampler {
            Sampler::Random => philox_one(self.counter(index), self.keys[0]),
            Sampler::Sobol => {
                // The index counts within one randomisation; the plan keeps it below 2^32.
                let index = index as u32;
                [
                    scramble(index, self.keys[0]),
                    scramble(pascal(index), self.keys[1]),
                ]
            }
        }
    }

    /// Returns the counter of the random point `index`.
    #[inline(always)]
    pub(crate) fn counter(&self, index: u64) -> [u32; 2] {
        [index as u32, (index >> 32) as u32 ^ self.keys[1]]
    }

    /// Returns the third coordinate of point `index`, as a cell of [0, 1) cut in 2^32.
    #[inline]
    pub(crate) fn third(&self, index: u64) -> u32 {
        match self.sampler {
            Sampler::Random => self.second_block(index)[0],
            Sampler::Sobol => scramble(dimension(&THIRD, index as u32), self.keys[2]),
        }
    }

    /// Returns the fourth coordinate of point `index`, as a cell of [0, 1) cut in 2^32.
    #[inline]
    pub(crate) fn fourth(&self, index: u64) -> u32 {
        match self.sampler {
            Sampler::Random => self.second_block(index)[1],
            Sampler::Sobol => scramble(dimension(&FOURTH, index as u32), self.keys[3]),
        }
    }

    /// Returns three random numbers for reflection number `bounce`, below 64, of ray `index`, below
    /// 2^48.
    ///
    /// They are random for every sampler.
    pub(crate) fn at_bounce(&self, index: u64, bounce: u32) -> [u32; 3] {
        let [first, second] = self.counters_at_bounce(index, bounce);
        let [a, b] = philox_one(first, self.keys[0]);
        let [c, _] = philox_one(second, self.keys[0]);
        [a, b, c]
    }

    /// Returns the two counters of the random numbers of [`Stream::at_bounce`].
    ///
    /// They have bits of their own for the number of the reflection, and one bit in which the two
    /// differ.
    #[inline(always)]
    pub(crate) fn counters_at_bounce(&self, index: u64, bounce: u32) -> [[u32; 2]; 2] {
        let [low, high] = self.counter(index);
        let high = high ^ ((bounce + 1) << 24);
        [[low, high], [low, high ^ 1 << 23]]
    }

    /// Returns two more random numbers for point `index`.
    #[inline]
    fn second_block(&self, index: u64) -> [u32; 2] {
        philox_one(self.second_counter(index), self.keys[0])
    }

    /// Returns the counter of two more random numbers for point `index`. It uses the top bit, which
    /// is free because an index stays below 2^62.
    #[inline(always)]
    pub(crate) fn second_counter(&self, index: u64) -> [u32; 2] {
        let [low, high] = self.counter(index);
        [low, high ^ 0x8000_0000]
    }
}

/// Returns the centre of cell `cell` of [0, 1) cut in 2^32, less 1/2. It lies in (-1/2, 1/2) and is
/// exact.
#[inline(always)]
pub(crate) fn centred(cell: u32) -> f64 {
    (f64::from((cell ^ 0x8000_0000) as i32) + 0.5) * (1.0 / 4_294_967_296.0)
}

/// Returns how many of the 2^32 cells have their centre below `share`, which lies in [0, 1].
///
/// The product and the difference are exact, as a number of 53 bits.
pub(crate) fn centres_below(share: f64) -> u64 {
    (share * 4_294_967_296.0 - 0.5).ceil().max(0.0) as u64
}

/// Mixes 64 bits bijectively (the finaliser of SplitMix64).
fn mix(word: u64) -> u64 {
    let word = word.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    word ^ (word >> 31)
}

/// Computes Philox2x32 with ten rounds, on many counters (`low`, `high`) at once, in place.
///
/// The numbers are below 2^32. They stand in 64 bits, as the products do, so that vectors need not
/// be packed and unpacked in every round.
#[inline(always)]
pub(crate) fn philox<const N: usize>(low: &mut [u64; N], high: &mut [u64; N], key: u32) {
    const WORD: u64 = u32::MAX as u64;
    for lane in 0..N {
        let (mut l, mut h, mut key) = (low[lane] & WORD, high[lane] & WORD, key);
        for _ in 0..10 {
            let product = l * 0xd256_d193;
            l = (product >> 32) ^ u64::from(key) ^ h;
            h = product & WORD;
            key = key.wrapping_add(0x9e37_79b9);
        }
        (low[lane], high[lane]) = (l, h);
    }
}

fn philox_one([low, high]: [u32; 2], key: u32) -> [u32; 2] {
    let (mut low, mut high) = ([u64::from(low)], [u64::from(high)]);
    philox(&mut low, &mut high, key);
    [low[0] as u32, high[0] as u32]
}

/// Scrambles by Owen's method the point whose digits are the bits of `reversed`, lowest bit first.
#[inline(always)]
pub(crate) fn scramble(reversed: u32, seed: u32) -> u32 {
    let mut x = reversed;
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// Returns the second dimension of the Sobol sequence, lowest bit first.
///
/// Its matrix is the Pascal matrix modulo 2. This is a Kronecker power, so five steps replace 32
/// columns.
#[inline(always)]
pub(crate) fn pascal(index: u32) -> u32 {
    let mut x = index;
    x ^= (x >> 1) & 0x5555_5555;
    x ^= (x >> 2) & 0x3333_3333;
    x ^= (x >> 4) & 0x0f0f_0f0f;
    x ^= (x >> 8) & 0x00ff_00ff;
    x ^= (x >> 16) & 0x0000_ffff;
    x
}

/// Returns the dimension of the Sobol sequence with the direction numbers `columns`, lowest bit
/// first.
fn dimension(columns: &[u32; 32], index: u32) -> u32 {
    let mut digits = 0;
    for (bit, column) in columns.iter().enumerate() {
        digits ^= column & 0_u32.wrapping_sub((index >> bit) & 1);
    }
    digits.reverse_bits()
}

/// Direction numbers of the fourth dimension, each with its bits reversed: what [`scramble`] takes
/// is their exclusive or over the bits of the index.
pub(crate) const FOURTH_REVERSED: [u32; 32] = {
    let mut columns = FOURTH;
    let mut i = 0;
    while i < 32 {
        columns[i] = columns[i].reverse_bits();
        i += 1;
    }
    columns
};

/// Direction numbers of the third dimension: polynomial x^2 + x + 1, m = 1, 3.
const THIRD: [u32; 32] = {
    let mut columns = [0_u32; 32];
    columns[0] = 1 << 31;
    columns[1] = 3 << 30;
    let mut i = 2;
    while i < 32 {
        columns[i] = columns[i - 1] ^ columns[i - 2] ^ (columns[i - 2] >> 2);
        i += 1;
    }
    columns
};

/// Direction numbers of the fourth dimension: polynomial x^3 + x + 1, m = 1, 3, 1.
const FOURTH: [u32; 32] = {
    let mut columns = [0_u32; 32];
    columns[0] = 1 << 31;
    columns[1] = 3 << 30;
    columns[2] = 1 << 29;
    let mut i = 3;
    while i < 32 {
        columns[i] = columns[i - 2] ^ columns[i - 3] ^ (columns[i - 3] >> 3);
        i += 1;
    }
    columns
};

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the known answers of the Random123 distribution (kat_vectors).
    #[test]
    fn philox_known_answers() {
        assert_eq!(philox_one([0, 0], 0), [0xff1d_ae59, 0x6cd1_0df2]);
        assert_eq!(
            philox_one([0xffff_ffff, 0xffff_ffff], 0xffff_ffff),
            [0x2c3f_628b, 0xab4f_d7ad]
        );
        assert_eq!(
            philox_one([0x243f_6a88, 0x85a3_08d3], 0x1319_8a2e),
            [0xdd7c_e038, 0xf62a_4c12]
        );
    }

    /// Checks the first points of the plain sequence, as Joe and Kuo's program prints them.
    #[test]
    fn sobol_first_points() {
        let points = [
            (0.0, 0.0, 0.0),
            (0.5, 0.5, 0.5),
            (0.25, 0.75, 0.75),
            (0.75, 0.25, 0.25),
        ];
        // scipy.stats.qmc.Sobol(3, scramble=False) gives the same set in Gray-code order.
        for (index, point) in [0_u32, 1, 2, 3].into_iter().zip(points) {
            let plain = [index, pascal(index), dimension(&THIRD, index)]
                .map(|digits| f64::from(digits.reverse_bits()) / 4_294_967_296.0);
            let expected = match index {
                0 | 1 => [point.0, point.1, point.2],
                // In natural order, 2 = (0.25, 0.75, ..) and 3 = (0.75, 0.25, ..).
                _ => [point.0, point.1, plain[2]],
            };
            assert_eq!(plain, expected, "point {index}");
        }
    }

    /// Checks that every elementary box of area 2^-10 holds exactly one of 1024 consecutive points.
    /// Such points are a (0, 10, 2)-net, which Owen scrambling must keep.
    #[test]
    fn scrambled_sobol_is_a_net() {
        let stream = Stream::new(Sampler::Sobol, 7, 20.0, 0.0, 3);
        let mut boxes = 0;
        for shape in 0..=10 {
            let mut seen = vec![0_u32; 1024];
            for index in 1024 * 5..1024 * 6 {
                let [x, y] = stream.pair(index);
                let (columns, rows) = (shape, 10 - shape);
                let column = (u64::from(x) << columns) >> 32;
                let row = (u64::from(y) << rows) >> 32;
                seen[((column << rows) + row) as usize] += 1;
            }
            assert!(
                seen.iter().all(|&count| count == 1),
                "boxes 2^-{shape} wide"
            );
            boxes += seen.len();
        }
        assert_eq!(boxes, 11 * 1024);
    }

    /// Computes the second dimension of the Sobol sequence, lowest bit first, from the rows of
    /// Pascal's triangle modulo 2.
    fn second_plainly(index: u32) -> u32 {
        let mut triangle = [[0_u32; 32]; 32];
        for row in 0..32 {
            triangle[row][0] = 1;
            for k in 1..=row {
                triangle[row][k] = (triangle[row - 1][k - 1] + triangle[row - 1][k]) % 2;
            }
        }
        (0..32).fold(0, |digits, k| {
            let digit = (0..32).map(|row| triangle[row][k] * ((index >> row) & 1));
            digits | (digit.sum::<u32>() % 2) << k
        })
    }

    /// Computes Vegdahl's hash of `digits`, lowest bit first, by arithmetic modulo 2^32 in 64 bits.
    fn scrambled_plainly(digits: u32, seed: u32) -> u32 {
        let modulus = 1_u64 << 32;
        let mut x = u64::from(digits);
        x ^= x * 0x3d20_adea % modulus;
        x = (x + u64::from(seed)) % modulus;
        x = x * (u64::from(seed >> 16) | 1) % modulus;
        x ^= x * 0x0552_6c56 % modulus;
        x ^= x * 0x53a2_2864 % modulus;
        (0..32).fold(0, |reversed, k| {
            reversed | (((x >> k) & 1) as u32) << (31 - k)
        })
    }

    /// Both axes are computed again plainly, each with the key of its own.
    #[test]
    fn each_axis_has_its_own_scramble() {
        let mut compared = 0;
        for randomisation in 0..16 {
            let stream = Stream::new(Sampler::Sobol, 11, 20.0, 30.0, randomisation);
            let [first, second, ..] = stream.keys;
            assert_ne!(first, second);
            for index in (0..64).chain([12_345, 0x8000_0001, u32::MAX]) {
                let expected = [
                    scrambled_plainly(index, first),
                    scrambled_plainly(second_plainly(index), second),
                ];
                assert_eq!(stream.pair(u64::from(index)), expected, "point {index}");
                compared += 1;
            }
        }
        assert_eq!(compared, 16 * 67);
    }

    /// Point 0 of the plain sequence is 0 on both axes, so its coordinates are the digital shifts.
    /// All their pairs of leading bits are equally frequent over many streams.
    #[test]
    fn shifts_of_the_axes_are_independent() {
        let streams = 4096;
        let mut seen = [0_i32; 16];
        for randomisation in 0..streams {
            let stream = Stream::new(Sampler::Sobol, 1, 0.0, 0.0, randomisation);
            let [x, y] = stream.pair(0).map(|cell| (cell >> 30) as usize);
            seen[4 * x + y] += 1;
        }
        // 256 are expected of each pair. Five binomial standard deviations are 5 x 15.5.
        assert!(seen.iter().all(|n| (n - 256).abs() < 78), "{seen:?}");
    }

    /// Checks the mixer that makes the keys against the first numbers of SplitMix64 with seed 0.
    #[test]
    fn keys_are_mixed_as_published() {
        let step = 0x9e37_79b9_7f4a_7c15_u64;
        let numbers = [0, step, step.wrapping_mul(2)].map(mix);
        assert_eq!(
            numbers,
            [
                0xe220_a839_7b1d_cdaf,
                0x6e78_9e6a_a1b9_65f4,
                0x06c4_5d18_8009_454f
            ]
        );
    }

    #[test]
    fn third_and_fourth_dimension_are_equidistributed() {
        let stream = Stream::new(Sampler::Sobol, 7, 20.0, 0.0, 3);
        for coordinate in [Stream::third, Stream::fourth] {
            let mut seen = [0_u32; 256];
            (0..256).for_each(|index| seen[(coordinate(&stream, index) >> 24) as usize] += 1);
            assert_eq!(seen, [1; 256]);
        }
    }

    /// Checks the first points of the fourth dimension, unscrambled, against the tables of Joe and
    /// Kuo.
    #[test]
    fn fourth_dimension_is_the_published_one() {
        let eighths = |index| dimension(&FOURTH, index).reverse_bits() >> 29;
        assert_eq!(
            [0, 1, 2, 3, 4, 5, 6, 7].map(eighths),
            [0, 4, 6, 2, 1, 5, 7, 3]
        );
    }

    /// Checks that no two of 2,000 streams (directions x randomisations x seeds) have the same
    /// keys.
    #[test]
    fn streams_are_distinct() {
        let mut keys = std::collections::HashSet::new();
        for seed in 0..5 {
            for angle in 0..25 {
                for randomisation in 0..16 {
                    keys.insert(
                        Stream::new(Sampler::Sobol, seed, f64::from(angle), 30.0, randomisation)
                            .keys,
                    );
                }
            }
        }
        assert_eq!(keys.len(), 2000);
    }

    #[test]
    fn centred_is_symmetric_and_inside() {
        assert_eq!(centred(0), -0.5 + 0.5 / 4_294_967_296.0);
        assert_eq!(centred(u32::MAX), 0.5 - 0.5 / 4_294_967_296.0);
        assert_eq!(centred(0x8000_0000), 0.5 / 4_294_967_296.0);
    }

    /// Shares at a centre, beside it by one unit in the last place, and anywhere: the cells below
    /// are counted as comparisons with their centres count them.
    #[test]
    fn centres_below_are_counted() {
        let centre = |cell: u64| centred(cell as u32) + 0.5;
        let mut cases = 0;
        for k in 0..20_000_u64 {
            let at = centre(k.wrapping_mul(0x9e37_79b9) & 0xffff_ffff);
            let anywhere = at * (1.0 - k as f64 * 1e-13);
            for share in [at, at.next_down(), at.next_up(), anywhere] {
                let count = centres_below(share);
                assert!(count == 0 || centre(count - 1) < share, "{share}");
                assert!(count == 1 << 32 || centre(count) >= share, "{share}");
                cases += 1;
            }
        }
        assert_eq!([0.0, 1.0].map(centres_below), [0, 1 << 32]);
        assert_eq!(cases, 80_000);
    }

    /// Checks that no random number is used twice: those of the launch, of the losses and of every
    /// reflection differ. Philox maps counters one to one, so equal counters would give equal
    /// pairs.
    #[test]
    fn launch_and_reflections_share_no_random_number() {
        let mut seen = std::collections::HashSet::new();
        let mut cases = 0;
        let stream = Stream::new(Sampler::Random, 5, 20.0, 10.0, 0);
        for index in [0, 1, 77, 1 << 20, (1 << 40) + 3] {
            seen.insert(stream.pair(index));
            seen.insert([stream.third(index), stream.fourth(index)]);
            cases += 2;
            for bounce in 0..64 {
                let [a, b, c] = stream.at_bounce(index, bounce);
                let pairs = stream.counters_at_bounce(index, bounce);
                let pairs = pairs.map(|counter| philox_one(counter, stream.keys[0]));
                assert_eq!([a, b, c], [pairs[0][0], pairs[0][1], pairs[1][0]]);
                seen.extend(pairs);
                cases += 2;
            }
        }
        assert_eq!((cases, seen.len()), (5 * 130, 5 * 130));
    }
}
