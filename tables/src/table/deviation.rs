//! Where the light of a table of rays goes: numbers of rays by the direction that they leave in,
//! jointly with their shift.
//!
//! Both come from the point of entry: in a cube with a dihedral error every sextant has shifts of
//! its own and a spot of its own, which the two distributions apart do not tell. Nearly all pairs
//! of a shift and a direction are empty, so that only the others are kept, in ascending order;
//! numbers of rays are added, as all counts are.

use std::cmp::Ordering;

/// Pools of shifts, and bins of the deviation: tangents of the angles from straight back, outside,
/// as [`crate::Path::deviation`] has them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Cells along each of u and v over the histogram's range; divides the number of its bins.
    pub cells: usize,
    /// Bins along each of the deviation's two components. Where their number is odd, straight back
    /// is in the middle of one.
    pub bins: usize,
    /// They cover [-range, range]; the outermost also hold what lies beyond.
    pub range: f64,
}

impl Grid {
    /// Most cells, and most bins, along an axis: places then fit 48 bits.
    pub const MOST: usize = 4096;

    /// The place of rays: `cell` and `bin` are (v, u) and (along v, across).
    pub fn place(&self, cell: [usize; 2], bin: [usize; 2]) -> u64 {
        let [cells, bins] = [self.cells, self.bins].map(|n| n as u64);
        let [[v, u], [along, across]] = [cell, bin].map(|pair| pair.map(|n| n as u64));
        ((v * cells + u) * bins + along) * bins + across
    }

    /// The cell (v, u) and the bin (along v, across) of a place.
    pub fn at(&self, place: u64) -> ([usize; 2], [usize; 2]) {
        let [cells, bins] = [self.cells, self.bins].map(|n| n as u64);
        let (cell, bin) = (place / (bins * bins), place % (bins * bins));
        let pair = |n: u64, of: u64| [n / of, n % of].map(|n| n as usize);
        (pair(cell, cells), pair(bin, bins))
    }

    /// Places in all.
    pub fn places(&self) -> u64 {
        [self.cells, self.cells, self.bins, self.bins]
            .iter()
            .map(|&n| n as u64)
            .product()
    }

    /// The bin of one component of a deviation.
    pub fn bin(&self, tangent: f64) -> usize {
        let position = (tangent + self.range) / self.bin_width();
        // A negative number becomes 0.
        (position as usize).min(self.bins - 1)
    }

    /// Width of a bin, a tangent.
    pub fn bin_width(&self) -> f64 {
        2.0 * self.range / self.bins as f64
    }

    /// The deviation (across, along v) in the middle of a bin (along v, across).
    pub fn deviation(&self, [along, across]: [usize; 2]) -> [f64; 2] {
        [across, along].map(|k| (k as f64 + 0.5) * self.bin_width() - self.range)
    }

    /// The place seen in a mirror that holds the plane of incidence: v is turned over.
    pub fn mirrored(&self, place: u64) -> u64 {
        let ([v, u], [along, across]) = self.at(place);
        self.place([self.cells - 1 - v, u], [self.bins - 1 - along, across])
    }

    /// Whether a bin is one of the outermost.
    pub fn is_outermost(&self, bin: [usize; 2]) -> bool {
        bin.iter().any(|&k| k == 0 || k + 1 == self.bins)
    }
}

/// Rays at one place of a [`Grid`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry {
    /// As [`Grid::place`] has it.
    pub place: u64,
    /// How many, above 0.
    pub rays: u64,
}

/// The rays of all directions by shift and deviation, all randomisations together.
#[derive(Debug, Clone, PartialEq)]
pub struct Deviations {
    /// Cells and bins.
    pub grid: Grid,
    /// Of each direction, index = incidence * azimuths + azimuth, by ascending place.
    pub entries: Vec<Vec<Entry>>,
}

/// The light of one direction by shift and deviation.
#[derive(Debug, Clone, PartialEq)]
pub struct Exits {
    /// Cells and bins.
    pub grid: Grid,
    /// Probability per launched ray of every place that has rays, ascending.
    pub probability: Vec<(u64, f64)>,
}

/// How far light goes from straight back.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spread {
    /// Root of the mean square, rad.
    pub rms_rad: f64,
    /// The largest, rad.
    pub largest_rad: f64,
    /// Share of the rays in the outermost bins, which may have gone beyond.
    pub outermost: f64,
}

impl Deviations {
    /// None of the directions has rays yet.
    pub fn new(grid: Grid, directions: usize) -> Deviations {
        Deviations {
            grid,
            entries: vec![Vec::new(); directions],
        }
    }

    /// The spread of one direction; all 0 where nothing returns.
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

/// Rays of two parts together.
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

/// The entries of rays at those places, which are sorted.
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
            // 4e-3 across, straight back, 8e-3 along.
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
