//! Differences between a photograph and its model, as tests of structure need them.
//!
//! All numbers are in units of their noise. If only noise is left, they are independent normal
//! numbers of variance 1. Sums over neighbours are normal numbers too. A misfit has the same sign
//! over many neighbours, so it shows in such sums long before it shows in single numbers.

/// Width of the sums across the edge, bins: two pixels. The edge of a mid-air image is wider.
const ACROSS: i64 = 8;

/// Width of the sums of an MTF, frequencies.
const FREQUENCIES: usize = 4;

/// Differences between one photograph and its model, in units of their noise.
#[derive(Debug, Clone, Default)]
pub struct Remainder {
    /// Sum of squares of all independent differences.
    pub squares: f64,
    /// Number of independent differences, less that of the photograph's own nuisances.
    pub freedom: usize,
    /// Sums over neighbours across the edge, or over neighbouring frequencies.
    pub across: Vec<f64>,
    /// Sums over neighbours across the edge of the changes along the edge. It is empty for an MTF.
    pub along: Vec<f64>,
}

/// Sum of normal numbers, as one normal number of variance 1.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    sum: f64,
    count: f64,
}

impl Sum {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1.0;
    }

    /// Returns the sum in units of its noise, or `None` if nothing was added.
    fn normal(self) -> Option<f64> {
        (self.count > 0.0).then(|| self.sum / self.count.sqrt())
    }
}

/// Sums of the differences of a photograph's bins, in the order of their distance from the edge.
#[derive(Debug, Default)]
pub(crate) struct Sums {
    block: Option<i64>,
    open: [Sum; 2],
    done: [Vec<f64>; 2],
}

impl Sums {
    /// Adds one number that tells of the bin with this number, and one that tells how the light
    /// changes along the edge there, if there is one.
    pub(crate) fn add(&mut self, number: i64, across: f64, along: Option<f64>) {
        let block = number.div_euclid(ACROSS);
        if self.block.replace(block) != Some(block) {
            self.close();
        }
        self.open[0].add(across);
        if let Some(along) = along {
            self.open[1].add(along);
        }
    }

    fn close(&mut self) {
        for (open, done) in self.open.iter_mut().zip(&mut self.done) {
            done.extend(std::mem::take(open).normal());
        }
    }

    /// Returns the sums across the edge, and those of the changes along it.
    pub(crate) fn finished(mut self) -> [Vec<f64>; 2] {
        self.close();
        self.done
    }
}

impl Remainder {
    /// Returns the sum of squares per degree of freedom.
    pub(crate) fn reduced(&self) -> f64 {
        self.squares / self.freedom.max(1) as f64
    }

    /// Makes the remainder of an MTF from the differences in units of their noise, in the order of
    /// the frequencies.
    pub(crate) fn of_mtf(differences: &[f64]) -> Remainder {
        let sums = differences.chunks(FREQUENCIES).filter_map(|chunk| {
            let mut sum = Sum::default();
            chunk.iter().for_each(|&value| sum.add(value));
            sum.normal()
        });
        Remainder {
            squares: differences.iter().map(|v| v * v).sum(),
            freedom: differences.len(),
            across: sums.collect(),
            along: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks sums by hand: bins 6 and 7 are one block, bin 8 begins the next one, and bins -1 and
    /// 0 lie in different blocks.
    #[test]
    fn neighbours_are_summed_in_blocks() {
        let mut sums = Sums::default();
        sums.add(-1, 5.0, None);
        sums.add(0, 1.0, Some(2.0));
        sums.add(6, 2.0, Some(4.0));
        sums.add(7, 3.0, None);
        sums.add(7, 4.0, None);
        sums.add(8, -1.0, Some(7.0));
        let [across, along] = sums.finished();
        assert_eq!(across, [5.0, 5.0, -1.0]);
        assert_eq!(along, [6.0 / 2_f64.sqrt(), 7.0]);
    }

    #[test]
    fn frequencies_are_summed_by_fours() {
        let remainder = Remainder::of_mtf(&[1.0, 1.0, 1.0, 1.0, -3.0]);
        assert_eq!(remainder.across, [2.0, -3.0]);
        assert_eq!((remainder.squares, remainder.freedom), (13.0, 5));
        assert!(remainder.along.is_empty());
    }
}
