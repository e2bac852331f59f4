//! Probabilities and standard errors from counts, and the distance between two tables.
//!
//! A table carries numbers of rays. Histogram, eta and errors follow from them by the rules here
//! and nowhere else. So tables are merged by adding counts, and a reader can check a table.

use ndarray::{Array2, Array3, Array4, Array5, ArrayView2, Axis};

use crate::table::axes::Axes;
use crate::table::fate::Fate;
use crate::table::provenance::Provenance;
use crate::table::table::Table;

impl Table {
    /// Returns the table that follows from numbers of rays.
    ///
    /// `counts` is `[incidence, azimuth, randomisation, v, u]`. `fate_counts` is `[incidence,
    /// azimuth, randomisation, fate]` in the order of [`Provenance::fates`].
    ///
    /// - `histogram` = counts / their sum, all 0 where nothing returned inside the histogram.
    /// - `retroreflected` = (retroreflected + out_of_range) / rays, 0 where no ray was launched.
    /// - `standard_error` is the binomial `sqrt(eta (1 - eta) / rays)` for the `random` sampler,
    ///   and where a single randomisation has rays. For a low-discrepancy sequence the binomial is
    ///   an upper bound in practice. Otherwise `standard_error` is that of the mean over the R >= 2
    ///   randomisations that have rays, `sqrt(R/(R-1) sum (n_r/n)^2 (eta_r - eta)^2)`. If all of
    ///   them have equally many rays, this is the sample standard deviation / sqrt(R).
    ///
    /// The error is 0 where eta is exactly 0 or 1, but eta is not certain there. With `n` random
    /// rays the 95 % bound is then about `3 / n` (the rule of three): eta < 3/n where none
    /// returned, eta > 1 - 3/n where all returned.
    ///
    /// # Panics
    /// Panics if the shapes disagree with the axes. The caller must check them before;
    /// [`crate::read()`] does.
    pub fn from_counts(
        axes: Axes,
        counts: Array5<u64>,
        fate_counts: Array4<u64>,
        provenance: Provenance,
    ) -> Table {
        let (incidences, azimuths) = axes.shape();
        let randomisations = counts.shape()[2];
        assert_eq!(
            counts.shape(),
            [incidences, azimuths, randomisations, axes.bins, axes.bins]
        );
        let fates = provenance.fates(fate_counts.shape()[3]).len();
        assert_eq!(
            fate_counts.shape(),
            [incidences, azimuths, randomisations, fates]
        );

        let mut histogram = Array4::zeros((incidences, azimuths, axes.bins, axes.bins));
        let mut retroreflected = Array2::zeros((incidences, azimuths));
        let mut standard_error = Array2::zeros((incidences, azimuths));
        let mut fate = Array3::zeros((incidences, azimuths, fates));
        let mut rays = Array2::zeros((incidences, azimuths));
        for i in 0..incidences {
            for j in 0..azimuths {
                let here = counts.index_axis(Axis(0), i).index_axis_move(Axis(0), j);
                let sum = here.sum_axis(Axis(0));
                let inside = sum.sum();
                if inside > 0 {
                    let share = sum.mapv(|n| n as f64 / inside as f64);
                    histogram
                        .index_axis_mut(Axis(0), i)
                        .index_axis_mut(Axis(0), j)
                        .assign(&share);
                }
                let fates = fate_counts
                    .index_axis(Axis(0), i)
                    .index_axis_move(Axis(0), j);
                let total = fates.sum();
                rays[[i, j]] = total;
                if total > 0 {
                    for (k, n) in fates.sum_axis(Axis(0)).iter().enumerate() {
                        fate[[i, j, k]] = *n as f64 / total as f64;
                    }
                }
                let random = provenance.is_random();
                (retroreflected[[i, j]], standard_error[[i, j]]) = returned(fates, random);
            }
        }
        Table {
            axes,
            histogram,
            counts: Some(counts),
            retroreflected,
            standard_error,
            fate,
            fate_counts: Some(fate_counts),
            rays,
            exact: None,
            deviations: None,
            provenance,
            passage: None,
            errors_rad: [0.0; 3],
        }
    }

    /// Returns the probability per launched ray of each bin, eta x histogram, of one direction `[v,
    /// u]`.
    pub fn probability(&self, incidence: usize, azimuth: usize) -> Array2<f64> {
        let histogram = self
            .histogram
            .index_axis(Axis(0), incidence)
            .index_axis_move(Axis(0), azimuth);
        histogram.mapv(|p| p * self.retroreflected[[incidence, azimuth]])
    }
}

/// Returns eta and its standard error from the rays `[randomisation, fate]`.
fn returned(fates: ArrayView2<u64>, random: bool) -> (f64, f64) {
    let returning = |row: ndarray::ArrayView1<u64>| {
        row[Fate::Retroreflected as usize] + row[Fate::OutOfRange as usize]
    };
    let total = fates.sum() as f64;
    if total == 0.0 {
        return (0.0, 0.0);
    }
    let eta = fates.rows().into_iter().map(returning).sum::<u64>() as f64 / total;
    let launched: Vec<_> = fates
        .rows()
        .into_iter()
        .filter(|row| row.sum() > 0)
        .collect();
    if random || launched.len() < 2 {
        return (eta, (eta * (1.0 - eta) / total).sqrt());
    }
    let spread: f64 = launched
        .iter()
        .map(|row| {
            let rays = row.sum() as f64;
            (rays / total * (returning(*row) as f64 / rays - eta)).powi(2)
        })
        .sum();
    let randomisations = launched.len() as f64;
    (
        eta,
        (spread * randomisations / (randomisations - 1.0)).sqrt(),
    )
}

/// Returns the distance of two tables for each direction, `[incidence, azimuth]`.
///
/// The distance is the sum over bins of |eta_a histogram_a - eta_b histogram_b|: 0 for equal
/// tables, at most 2. The total variation is half of it. It compares probabilities per launched
/// ray, so it is well defined for empty and nearly empty directions. Directions are compared by
/// position.
///
/// # Panics
/// Panics if the tables have different axes. Compare `a.axes == b.axes` before.
pub fn l1(a: &Table, b: &Table) -> Array2<f64> {
    assert_eq!(a.axes, b.axes, "tables of different axes have no distance");
    Array2::from_shape_fn(a.axes.shape(), |(i, j)| {
        (a.probability(i, j) - b.probability(i, j))
            .mapv(f64::abs)
            .sum()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    #[test]
    fn standard_errors_follow_their_formulas() {
        // Columns: retroreflected, ..., missed, out_of_range.
        let row = |r: u64, m: u64, o: u64| [r, 0, 0, 0, 0, 0, 0, m, o, 0];
        let two = array![row(60, 30, 10), row(50, 50, 0)];
        // eta_r = 0.7 and 0.5: mean 0.6, sample standard deviation 0.1 sqrt 2, over sqrt 2 = 0.1.
        let (eta, error) = returned(two.view(), false);
        assert!(
            (eta - 0.6).abs() < 1e-15 && (error - 0.1).abs() < 1e-15,
            "{eta} {error}"
        );
        let (_, binomial) = returned(two.view(), true);
        assert!(
            (binomial - (0.24_f64 / 200.0).sqrt()).abs() < 1e-15,
            "{binomial}"
        );
        // A randomisation without rays (those of another shard) is not a sample of eta.
        let shard = array![row(60, 30, 10), row(50, 50, 0), row(0, 0, 0)];
        assert_eq!(returned(shard.view(), false), (eta, error));
        assert_eq!(returned(array![row(0, 0, 0)].view(), true), (0.0, 0.0));
        assert_eq!(returned(array![row(0, 9, 0)].view(), true), (0.0, 0.0));
    }

    /// Three randomisations of 10, 20 and 10 rays return 5, 14 and 9 of them, so eta is 0.7. They
    /// are off by -0.2, 0 and 0.2, with weights of 1/4, 1/2 and 1/4: the squares sum to 0.005, and
    /// R/(R - 1) is 3/2.
    #[test]
    fn standard_error_of_unequal_randomisations_by_hand() {
        let row = |back: u64, missed: u64| [back, 0, 0, 0, 0, 0, 0, missed, 0, 0];
        let three = array![row(5, 5), row(14, 6), row(9, 1)];
        let (eta, error) = returned(three.view(), false);
        assert!((eta - 0.7).abs() < 1e-15);
        // All numbers are below 1 and round by an ulp each.
        assert!((error - 0.0075_f64.sqrt()).abs() < 1e-15, "{error}");
    }
}
