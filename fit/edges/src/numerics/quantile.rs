//! Inverse of a distribution function that is given by the masses of equal cells.

/// Quantiles of a distribution that is even within each cell.
#[derive(Debug, Clone)]
pub struct Quantile {
    first: f64,
    step: f64,
    /// Distribution function at the ends of the cells.
    below: Vec<f64>,
    /// Cell that holds the quantile of k / cells, for each k.
    guide: Vec<u32>,
}

impl Quantile {
    /// Builds the distribution from cells of width `step` that begin at `first`, with masses >= 0.
    /// Returns `None` if there is no mass.
    pub fn new(first: f64, step: f64, masses: &[f64]) -> Option<Quantile> {
        let total: f64 = masses.iter().sum();
        if !(total.is_finite() && total > 0.0) {
            return None;
        }
        let mut below = Vec::with_capacity(masses.len() + 1);
        let mut sum = 0.0;
        below.push(0.0);
        for mass in masses {
            sum += mass;
            below.push(sum / total);
        }
        let last = masses.iter().rposition(|&m| m > 0.0).unwrap_or(0);
        let mut cell = 0;
        let guide = (0..=masses.len())
            .map(|k| {
                let share = k as f64 / masses.len() as f64;
                while cell < last && below[cell + 1] <= share {
                    cell += 1;
                }
                cell as u32
            })
            .collect();
        Some(Quantile {
            first,
            step,
            below,
            guide,
        })
    }

    /// Returns the quantile of `share` in [0, 1), and the cell in which it lies.
    pub fn at(&self, share: f64) -> (f64, usize) {
        let cells = self.below.len() - 1;
        let mut cell = self.guide[((share * cells as f64) as usize).min(cells)] as usize;
        while cell + 1 < cells && self.below[cell + 1] <= share {
            cell += 1;
        }
        let [low, high] = [self.below[cell], self.below[cell + 1]];
        let part = ((share - low) / (high - low)).clamp(0.0, 1.0);
        (self.first + self.step * (cell as f64 + part), cell)
    }

    /// Returns the share of the mass below the left end of a cell.
    pub fn below(&self, cell: usize) -> f64 {
        self.below[cell]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with an inversion by hand of cells of masses 0, 1, 0, 3, 0 between -1 and 1.5.
    /// Empty cells hold no quantile.
    #[test]
    fn quantiles_skip_empty_cells() {
        let q = Quantile::new(-1.0, 0.5, &[0.0, 1.0, 0.0, 3.0, 0.0]).expect("there is mass");
        let expected = [
            (0.0, -0.5, 1),
            (0.125, -0.25, 1),
            (0.25, 0.5, 3),
            (0.625, 0.75, 3),
            (1.0 - 1e-12, 1.0, 3),
        ];
        for (share, value, cell) in expected {
            let (x, at) = q.at(share);
            assert!((x - value).abs() < 1e-11 && at == cell, "{share}: {x} {at}");
        }
        assert_eq!(q.below(3), 0.25);
        assert!(Quantile::new(0.0, 1.0, &[0.0, 0.0]).is_none());
    }
}
