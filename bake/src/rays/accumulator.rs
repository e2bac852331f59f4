//! Integer counts of fates and of shifts by bin, which give the same bytes in any order of
//! summation.

use crate::rays::lane::LANES;
use crate::rays::path::Outcome;
use glam::DVec2;
use ndarray::s;
use tables::deviation::{Entry, Grid, added, counted};
use tables::{Fate, Table};

/// Counts of one run of rays of one direction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Accumulator {
    /// Number of rays by bin, v slow, u fast.
    ///
    /// After the bins come [`LANES`] slots for the rays of the fast kernel that fall in no bin.
    pub histogram: Vec<u32>,
    /// Number of rays by fate, in the order of [`Fate::ALL`].
    pub fates: [u64; Fate::ALL.len()],
    /// Places of rays in the histogram of deviations; empty if there is no such histogram.
    pub exits: Vec<u64>,
    /// Places with numbers of rays in that histogram, for rays that were counted together.
    pub entries: Vec<Entry>,
}

impl Accumulator {
    /// Makes empty counts.
    ///
    /// An accumulator takes at most 2^32 - 1 rays; runs are shorter than that.
    pub(crate) fn new(bins: &Bins) -> Self {
        Accumulator {
            histogram: vec![0; bins.len() + LANES],
            fates: [0; Fate::ALL.len()],
            exits: Vec::new(),
            entries: Vec::new(),
        }
    }

    /// Takes the rays by deviation out of the accumulator: each place once, ascending.
    pub(crate) fn take_exits(&mut self) -> Vec<Entry> {
        let alone = counted(&mut self.exits);
        self.exits.clear();
        let mut entries = std::mem::take(&mut self.entries);
        entries.sort_unstable_by_key(|entry| entry.place);
        entries.dedup_by(|next, kept| {
            let same = next.place == kept.place;
            kept.rays += if same { next.rays } else { 0 };
            same
        });
        added(&alone, &entries)
    }

    /// Sets all counts back to zero.
    pub(crate) fn clear(&mut self) {
        self.histogram.fill(0);
        self.fates.fill(0);
        self.exits.clear();
        self.entries.clear();
    }

    /// Counts one ray.
    pub(crate) fn count(&mut self, bins: &Bins, outcome: &Outcome) {
        if outcome.fate == Fate::Retroreflected {
            self.count_shift(bins, outcome.shift);
        } else {
            self.fates[outcome.fate as usize] += 1;
        }
    }

    /// Counts one retroreflected ray with the shift `shift`.
    #[inline]
    pub(crate) fn count_shift(&mut self, bins: &Bins, shift: DVec2) {
        let fate = if let Some(bin) = bins.find(shift) {
            self.histogram[bin] += 1;
            Fate::Retroreflected
        } else {
            Fate::OutOfRange
        };
        self.fates[fate as usize] += 1;
    }

    /// Records the exit direction of a retroreflected ray with this shift and deviation.
    pub(crate) fn count_exit(&mut self, bins: &Bins, grid: &Grid, shift: DVec2, deviation: DVec2) {
        if let Some(bin) = bins.find(shift) {
            let pool = bins.count / grid.cells;
            let cell = [bin / bins.count, bin % bins.count].map(|k| k / pool);
            let at = [grid.bin(deviation.y), grid.bin(deviation.x)];
            self.exits.push(grid.place(cell, at));
        }
    }
}

/// Sums of one direction, by randomisation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Sums {
    /// Number of rays by `[randomisation, v, u]`.
    pub counts: Vec<u64>,
    /// Number of rays by randomisation and fate.
    pub fates: Vec<[u64; Fate::ALL.len()]>,
    /// Number of rays launched, by randomisation.
    pub launched: Vec<u64>,
    /// Number of rays by shift and deviation, over all randomisations.
    pub deviations: Vec<Entry>,
}

impl Sums {
    /// Makes empty sums for so many `randomisations`.
    pub(crate) fn new(bins: &Bins, randomisations: usize) -> Self {
        Sums {
            counts: vec![0; bins.len() * randomisations],
            fates: vec![[0; Fate::ALL.len()]; randomisations],
            launched: vec![0; randomisations],
            deviations: Vec::new(),
        }
    }

    /// Returns the sums that a table of rays was made of, one per direction; empty without counts.
    pub(crate) fn of_table(table: &Table) -> Vec<Self> {
        let (Some(counts), Some(fates)) = (&table.counts, &table.fate_counts) else {
            return Vec::new();
        };
        let (incidences, azimuths) = table.axes.shape();
        let of = |direction: usize| {
            let (i, j) = (direction / azimuths, direction % azimuths);
            let counts = counts.slice(s![i, j, .., .., ..]);
            let fates = fates.slice(s![i, j, .., ..]);
            let fates: Vec<[u64; Fate::ALL.len()]> = fates
                .rows()
                .into_iter()
                .map(|row| std::array::from_fn(|fate| row.get(fate).copied().unwrap_or(0)))
                .collect();
            let deviations = table.deviations.as_ref();
            Sums {
                deviations: deviations.map_or(Vec::new(), |found| found.entries[direction].clone()),
                counts: counts.iter().copied().collect(),
                launched: fates.iter().map(|fates| fates.iter().sum()).collect(),
                fates,
            }
        };
        (0..incidences * azimuths).map(of).collect()
    }

    /// Adds the counts of one run to a randomisation.
    pub(crate) fn add(&mut self, randomisation: usize, accumulator: &Accumulator) {
        let size = accumulator.histogram.len() - LANES;
        let counts = &mut self.counts[randomisation * size..][..size];
        for (sum, &count) in counts.iter_mut().zip(&accumulator.histogram) {
            *sum += u64::from(count);
        }
        for (sum, &count) in self.fates[randomisation].iter_mut().zip(&accumulator.fates) {
            *sum += count;
        }
        self.launched[randomisation] += accumulator.fates.iter().sum::<u64>();
    }

    /// Adds rays by shift and deviation.
    pub(crate) fn add_exits(&mut self, exits: &[Entry]) {
        if !exits.is_empty() {
            self.deviations = added(&self.deviations, exits);
        }
    }

    /// Returns the number of rays launched in all randomisations.
    pub(crate) fn rays(&self) -> u64 {
        self.launched.iter().sum()
    }

    /// Returns the number of rays of `fate` in all randomisations.
    #[cfg(test)]
    pub(crate) fn of(&self, fate: Fate) -> u64 {
        self.fates.iter().map(|fates| fates[fate as usize]).sum()
    }

    /// Estimates the L1 error of eta x histogram.
    ///
    /// The estimate is the sum over bins of the mean absolute error of a normal variable with the
    /// bin's standard error sigma, which is sqrt(2/pi) sigma. With one randomisation sigma is
    /// binomial. With R randomisations it is their standard deviation s over sqrt R. Here (R - 1)
    /// s^2 / sigma^2 is chi-squared with R - 1 degrees of freedom, so the mean of s is c4 sigma
    /// (`mean_deviation`), and every s is divided by c4.
    ///
    /// Bins that no ray has met count as exact. So the estimate is too low while most bins hold
    /// less than one ray.
    pub(crate) fn l1_error(&self) -> f64 {
        let runs = self.launched.len();
        let size = self.counts.len() / runs.max(1);
        let rays = self.rays().max(1) as f64;
        let sigma = |bin: usize| {
            let sum: u64 = (0..runs).map(|run| self.counts[run * size + bin]).sum();
            if sum == 0 {
                return 0.0;
            }
            let mean = sum as f64 / rays;
            if runs < 2 {
                return (mean * (1.0 - mean) / rays).sqrt();
            }
            let squares: f64 = (0..runs)
                .map(|run| {
                    self.counts[run * size + bin] as f64 / self.launched[run].max(1) as f64 - mean
                })
                .map(|x| x * x)
                .sum();
            (squares / (runs * (runs - 1)) as f64).sqrt()
        };
        let mean = (2.0 / std::f64::consts::PI).sqrt() / mean_deviation(runs);
        mean * (0..size).map(sigma).sum::<f64>()
    }
}

/// Returns c4, the mean standard deviation of `samples` normal values as a part of the true one.
///
/// The standard deviation has n - 1 in its denominator. c4 is 0.921 for 4 samples and 0.983 for 16.
/// A single sample has no standard deviation, and the result is 1.
fn mean_deviation(samples: usize) -> f64 {
    if samples < 2 {
        return 1.0;
    }
    let n = samples as f64;
    (2.0 / (n - 1.0)).sqrt() * libm::exp(libm::lgamma(n / 2.0) - libm::lgamma((n - 1.0) / 2.0))
}

/// Bins of a histogram over u, v in [-range, range].
///
/// A bin holds its lower edge and not its upper edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bins {
    /// Number of bins along each axis.
    pub count: usize,
    /// Number of bins per edge length.
    pub density: f64,
}

impl Bins {
    /// Makes `count` bins along each axis over [-range, range] edge lengths.
    pub(crate) fn new(count: usize, range: f64) -> Self {
        Bins {
            count,
            density: count as f64 / (2.0 * range),
        }
    }

    /// Returns the number of bins of the whole histogram.
    pub(crate) fn len(&self) -> usize {
        self.count * self.count
    }

    /// Returns the place of a shift (u, v), counted in bins from the lower end of the histogram.
    pub(crate) fn position(&self, shift: DVec2) -> DVec2 {
        shift * self.density + DVec2::splat(self.count as f64 / 2.0)
    }

    /// Returns the bin of a shift, v slow, u fast, or `None` if the shift lies outside the
    /// histogram.
    pub(crate) fn find(&self, shift: DVec2) -> Option<usize> {
        let at = self.position(shift);
        let end = self.count as f64;
        let within = at.x >= 0.0 && at.y >= 0.0 && at.x < end && at.y < end;
        within.then(|| at.y as usize * self.count + at.x as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with sqrt(2/pi), 2 sqrt(2)/sqrt(3 pi) and the tabulated c4 of 16 samples.
    #[test]
    fn mean_deviations_are_those_of_the_tables() {
        let cases = [
            (1, 1.0),
            (2, 0.797_884_561),
            (4, 0.921_317_732),
            (16, 0.983_484_0),
        ];
        for (samples, c4) in cases {
            assert!(
                (mean_deviation(samples) - c4).abs() < 1e-6,
                "{samples}: {}",
                mean_deviation(samples)
            );
        }
    }

    /// Makes the sums of randomisations with these counts by bin; the rest of `launched` missed.
    fn sums(launched: u64, runs: &[[u64; 2]]) -> Sums {
        let mut sums = Sums::new(&Bins::new(1, 1.0), runs.len());
        sums.counts = runs.iter().flatten().copied().collect();
        sums.launched.fill(launched);
        sums
    }

    /// Two randomisations of a normal variable differ by sqrt 2 s, and the mean of s is c4 sigma.
    /// With c4 = sqrt(2/pi) the factors of the estimate cancel. It is half of the difference.
    #[test]
    fn l1_error_of_two_randomisations_is_half_of_their_distance() {
        // Shares 3/8 and 1/8 in one bin, 0 and 1/2 in the other: 1/2 (1/4 + 1/2).
        let two = sums(8, &[[3, 0], [1, 4]]).l1_error();
        // The gamma functions, the roots and the quotients round by some ulps of 1.
        assert!((two - 0.375).abs() < 16.0 * f64::EPSILON, "{two}");
    }

    /// Shares of 1/8, 2/8 and 3/8 have the variance 1/64, with R - 1 = 2 in its denominator. The
    /// standard error of their mean is 1/(8 sqrt 3), and c4 of three values is sqrt(pi)/2.
    #[test]
    fn l1_error_of_three_randomisations_by_hand() {
        let three = sums(8, &[[1, 0], [2, 0], [3, 0]]).l1_error();
        let pi = std::f64::consts::PI;
        let expected = (2.0 / pi).sqrt() / (pi.sqrt() / 2.0) / (8.0 * 3_f64.sqrt());
        assert!((three - expected).abs() < 16.0 * f64::EPSILON, "{three}");
    }

    /// One randomisation has the binomial error sqrt(p (1 - p) / n) in every bin, here with p = 1/4
    /// and 1/2.
    #[test]
    fn l1_error_of_one_randomisation_is_binomial() {
        let one = sums(16, &[[4, 8]]).l1_error();
        let bins = (3.0_f64 / 16.0 / 16.0).sqrt() + (1.0_f64 / 4.0 / 16.0).sqrt();
        let expected = (2.0 / std::f64::consts::PI).sqrt() * bins;
        assert!((one - expected).abs() < 16.0 * f64::EPSILON, "{one}");
    }

    #[test]
    fn every_ray_is_counted_once() {
        let bins = Bins::new(8, 1.0);
        let mut accumulator = Accumulator::new(&bins);
        let fates = [
            Fate::Missed,
            Fate::Retroreflected,
            Fate::Retroreflected,
            Fate::Deviated,
        ];
        for (i, fate) in fates.into_iter().enumerate() {
            accumulator.count(
                &bins,
                &Outcome {
                    fate,
                    shift: DVec2::splat(0.6 * i as f64),
                    bounces: 0,
                    travel: glam::DVec3::Z,
                },
            );
        }
        let mut sums = Sums::new(&bins, 1);
        sums.add(0, &accumulator);
        assert_eq!(sums.rays(), 4);
        assert_eq!(sums.of(Fate::Retroreflected), 1);
        assert_eq!(sums.of(Fate::OutOfRange), 1, "a shift of 1.2 lies outside");
    }

    #[test]
    fn bins_hold_their_lower_edge() {
        let bins = Bins::new(4, 2.0);
        assert_eq!(bins.find(DVec2::new(-2.0, -2.0)), Some(0));
        assert_eq!(bins.find(DVec2::new(-1.0, -2.0)), Some(1));
        assert_eq!(bins.find(DVec2::new(-2.0, -1.0)), Some(4));
        assert_eq!(bins.find(DVec2::new(1.999_999, 1.999_999)), Some(15));
        assert_eq!(bins.find(DVec2::new(2.0, 0.0)), None);
        assert_eq!(bins.find(DVec2::new(0.0, -2.000_001)), None);
        assert_eq!(bins.find(DVec2::new(f64::NAN, 0.0)), None);
    }
}
