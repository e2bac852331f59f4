//! Numbers of rays by their shift and by the direction in which they leave, for tables of rays.
//!
//! Shift and deviation are counted jointly, because both follow from the point of entry. In a cube
//! with a dihedral error every sextant has its own shifts and its own spot; two separate
//! distributions would not tell which belong together. Nearly all pairs of a shift and a deviation
//! are empty. The other pairs are listed in ascending order. Tables are merged by adding their
//! numbers of rays.

use std::cmp::Ordering;

/// Grid of pools of shifts and of bins of the deviation.
///
/// Deviations are tangents of the angles from straight back, outside the sheet, with the two
/// components of [`crate::Path::deviation`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Number of cells along each of u and v over the range of the histogram; a divisor of the
    /// number of its bins.
    pub cells: usize,
    /// Number of bins along each of the two components of the deviation. If it is odd, straight
    /// back is in the middle of a bin.
    pub bins: usize,
    /// Half width of the bins, a tangent: they cover [-range, range]. The outermost bins also hold
    /// the light beyond.
    pub range: f64,
}

impl Grid {
    /// Most cells, and most bins, along an axis: a place then fits 48 bits.
    pub const MOST: usize = 4096;

    /// Returns the place of a ray from its cell (v, u) and its bin (along v, across).
    pub fn place(&self, cell: [usize; 2], bin: [usize; 2]) -> u64 {
        let [cells, bins] = [self.cells, self.bins].map(|n| n as u64);
        let [[v, u], [along, across]] = [cell, bin].map(|pair| pair.map(|n| n as u64));
        ((v * cells + u) * bins + along) * bins + across
    }

    /// Returns the cell (v, u) and the bin (along v, across) of a place.
    pub fn at(&self, place: u64) -> ([usize; 2], [usize; 2]) {
        let [cells, bins] = [self.cells, self.bins].map(|n| n as u64);
        let (cell, bin) = (place / (bins * bins), place % (bins * bins));
        let pair = |n: u64, of: u64| [n / of, n % of].map(|n| n as usize);
        (pair(cell, cells), pair(bin, bins))
    }

    /// Returns the number of places.
    pub fn places(&self) -> u64 {
        [self.cells, self.cells, self.bins, self.bins]
            .iter()
            .map(|&n| n as u64)
            .product()
    }

    /// Returns the bin of one component of a deviation.
    pub fn bin(&self, tangent: f64) -> usize {
        let position = (tangent + self.range) / self.bin_width();
        // The cast turns a negative number into 0.
        (position as usize).min(self.bins - 1)
    }

    /// Returns the width of a bin, a tangent.
    pub fn bin_width(&self) -> f64 {
        2.0 * self.range / self.bins as f64
    }

    /// Returns the deviation (across, along v) in the middle of a bin (along v, across).
    pub fn deviation(&self, [along, across]: [usize; 2]) -> [f64; 2] {
        [across, along].map(|k| (k as f64 + 0.5) * self.bin_width() - self.range)
    }

    /// Returns the place seen in a mirror that holds the plane of incidence: v changes its sign.
    pub fn mirrored(&self, place: u64) -> u64 {
        let ([v, u], [along, across]) = self.at(place);
        self.place([self.cells - 1 - v, u], [self.bins - 1 - along, across])
    }

    /// Returns whether a bin is one of the outermost.
    pub fn is_outermost(&self, bin: [usize; 2]) -> bool {
        bin.iter().any(|&k| k == 0 || k + 1 == self.bins)
    }
}

/// Rays at one place of a [`Grid`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry {
    /// Place that [`Grid::place`] returns.
    pub place: u64,
    /// Number of rays, above 0.
    pub rays: u64,
}

/// Rays of all directions by shift and deviation, all randomisations together.
#[derive(Debug, Clone, PartialEq)]
pub struct Deviations {
    /// Cells and bins.
    pub grid: Grid,
    /// Entries of each direction by ascending place; index = incidence * azimuths + azimuth.
    pub entries: Vec<Vec<Entry>>,
}

/// Light of one direction by shift and deviation.
#[derive(Debug, Clone, PartialEq)]
pub struct Exits {
    /// Cells and bins.
    pub grid: Grid,
    /// Probability per launched ray of every place that has rays, by ascending place.
    pub probability: Vec<(u64, f64)>,
}

/// Angles between the returned light and straight back.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spread {
    /// Root of the mean square of the angle, rad.
    pub rms_rad: f64,
    /// Largest angle, rad.
    pub largest_rad: f64,
    /// Share of the rays in the outermost bins, whose true deviation may be larger.
    pub outermost: f64,
}

impl Deviations {
    /// Makes lists without rays for all directions.
    pub fn new(grid: Grid, directions: usize) -> Deviations {
        Deviations {
            grid,
            entries: vec![Vec::new(); directions],
        }
    }

    /// Returns the half width of bins that are fine enough for the light, mrad, as `--deviations`
    /// takes it: eight times the largest rms angle, and at least a twentieth of the present one.
    pub fn advised_mrad(&self) -> f64 {
        let spreads = (0..self.entries.len()).map(|direction| self.spread(direction));
        let rms_rad = spreads.map(|spread| spread.rms_rad).fold(0.0, f64::max);
        1e3 * (self.grid.range / 20.0).max(8.0 * rms_rad)
    }

    /// Returns the spread of one direction; all 0 where nothing returns.
    pub fn spread(&self, direction: usize) -> Spread {
        let mut spread = Spread::default();
        let (mut squares, mut outermost, mut total) = (0.0, 0, 0);
        for entry in &self.entries[direction] {
            let (_, bin) = self.grid.at(entry.place);
            let [across, along] = self.grid.deviation(bin);
            let angle = across.hypot(along).atan();
            squares += entry.rays as f64 * angle * angle;
            spread.largest_rad = spread.largest_rad.max(angle);
            total += entry.rays;
            if self.grid.is_outermost(bin) {
                outermost += entry.rays;
            }
        }
        let total = (total as f64).max(1.0);
        spread.rms_rad = (squares / total).sqrt();
        spread.outermost = outermost as f64 / total;
        spread
    }
}

/// Adds the rays of two lists, place by place.
pub fn added(a: &[Entry], b: &[Entry]) -> Vec<Entry> {
    let mut sum = Vec::with_capacity(a.len().max(b.len()));
    let (mut a, mut b) = (a.iter().peekable(), b.iter().peekable());
    loop {
        let order = match (a.peek(), b.peek()) {
            (None, None) => return sum,
            (Some(_), None) => Ordering::Less,
            (None, Some(_)) => Ordering::Greater,
            (Some(a), Some(b)) => a.place.cmp(&b.place),
        };
        let first = if order.is_le() { a.next() } else { None };
        let second = if order.is_ge() { b.next() } else { None };
        sum.extend(match (first, second) {
            (Some(a), Some(b)) => Some(Entry {
                rays: a.rays + b.rays,
                ..*a
            }),
            (one, other) => one.or(other).copied(),
        });
    }
}

/// Sorts the places of rays and counts the rays at each place.
pub fn counted(places: &mut [u64]) -> Vec<Entry> {
    places.sort_unstable();
    let groups = places.chunk_by(|a, b| a == b);
    let entry = |group: &[u64]| Entry {
        place: group[0],
        rays: group.len() as u64,
    };
    groups.map(entry).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: Grid = Grid {
        cells: 3,
        bins: 5,
        range: 1e-2,
    };

    #[test]
    fn places_and_bins_there_and_back() {
        let mut places = 0;
        for cell in [[0, 0], [1, 2], [2, 1]] {
            for bin in [[0, 4], [2, 2], [3, 1]] {
                let place = GRID.place(cell, bin);
                assert!(place < GRID.places());
                assert_eq!(GRID.at(place), (cell, bin));
                let mirrored = GRID.at(GRID.mirrored(place));
                let there = GRID.deviation(mirrored.1);
                assert_eq!(mirrored.0, [2 - cell[0], cell[1]]);
                assert!((there[0] - GRID.deviation(bin)[0]).abs() < 1e-17);
                assert!((there[1] + GRID.deviation(bin)[1]).abs() < 1e-17);
                let [across, along] = GRID.deviation(bin);
                assert_eq!([GRID.bin(along), GRID.bin(across)], bin);
                places += 1;
            }
        }
        assert_eq!(places, 9);
        assert_eq!(GRID.deviation([2, 2]), [0.0, 0.0], "straight back");
        assert_eq!(
            [-1.0, -0.0101, 0.0101, 1.0].map(|x| GRID.bin(x)),
            [0, 0, 4, 4]
        );
        assert!(
            GRID.is_outermost([0, 2]) && GRID.is_outermost([2, 4]) && !GRID.is_outermost([1, 3])
        );
    }

    #[test]
    fn sums_are_those_of_all_rays_at_once() {
        let all = [7, 1, 1, 9, 3, 7, 7, 2, 9, 1];
        let mut whole = all.to_vec();
        let whole = counted(&mut whole);
        assert_eq!(whole.iter().map(|e| e.rays).sum::<u64>(), 10);
        for cut in 0..=all.len() {
            let [a, b] = [&all[..cut], &all[cut..]].map(|part| counted(&mut part.to_vec()));
            assert_eq!(added(&a, &b), whole, "cut at {cut}");
        }
    }

    #[test]
    fn spread_by_hand() {
        let at = |bin, rays| Entry {
            place: GRID.place([1, 1], bin),
            rays,
        };
        let deviations = Deviations {
            grid: GRID,
            // The light goes 4e-3 across, straight back, and 8e-3 along v.
            entries: vec![vec![at([2, 2], 2), at([2, 3], 1), at([4, 2], 1)], vec![]],
        };
        let spread = deviations.spread(0);
        assert!((spread.largest_rad - 8e-3_f64.atan()).abs() < 1e-15);
        let squares = 4e-3_f64.atan().powi(2) + 8e-3_f64.atan().powi(2);
        assert!((spread.rms_rad - (squares / 4.0).sqrt()).abs() < 1e-15);
        assert_eq!(spread.outermost, 0.25);
        assert_eq!(deviations.spread(1), Spread::default());
    }
}
