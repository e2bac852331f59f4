//! Bins of exit directions in a table of rays: what they take from an MTF, and from which distance
//! on that is too much.

use std::f64::consts::PI;

use tables::Table;
use tables::deviation::Deviations;

use edges::numerics::sinc;

/// Loss of an MTF above which bins are too coarse.
const MOST_LOST: f64 = 0.01;

/// Step and number of the products of frequency, distance and width of a bin, cycles, at which the
/// loss is looked for.
const STEPS: (f64, usize) = (0.02, 50);

/// Bins of exit directions of a table.
///
/// A deviation is known to a bin of width w only. So at the frequency f and the distance R the MTF
/// of a smooth lobe is sinc(f R w) of the true one. Where all light lies in a bin or two, the true
/// one is about as much lower as it may be spread within them. From half a cycle for each bin on,
/// the bins are a grating: the MTF rises again to a peak at one cycle, and none of it may be true.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ExitBins<'t>(&'t Deviations);

impl ExitBins<'_> {
    /// Returns the bins of a table; `None` without recorded exit directions.
    pub(crate) fn of(table: &Table) -> Option<ExitBins<'_>> {
        table.deviations.as_ref().map(ExitBins)
    }

    /// Returns by how much an MTF of the table may be off at the distance `r_mm`; `mtf` gives it at
    /// a frequency, 1/mm.
    pub(crate) fn lost(&self, r_mm: f64, mtf: impl Fn(f64) -> f64) -> f64 {
        let (step, count) = STEPS;
        let per_mm = 1.0 / (r_mm * self.0.grid.bin_width());
        (1..=count)
            .map(|k| {
                let x = step * k as f64;
                let lost = if x > 0.5 {
                    1.0
                } else {
                    1.0 / sinc(PI * x) - 1.0
                };
                mtf(x * per_mm) * lost
            })
            .fold(0.0, f64::max)
    }

    /// Returns a sentence if the bins are too coarse at the distance `r_mm`, with the distance from
    /// which on they are; `mtf` gives the MTF at a distance, mm, and a frequency, 1/mm.
    pub(crate) fn too_coarse(&self, r_mm: f64, mtf: impl Fn(f64, f64) -> f64) -> Option<String> {
        let lost = |r_mm: f64| self.lost(r_mm, |frequency| mtf(r_mm, frequency));
        let here = lost(r_mm);
        if here <= MOST_LOST {
            return None;
        }
        let (mut near, mut far) = (0.0, r_mm);
        while far - near > 1e-3 * far {
            let middle = 0.5 * (near + far);
            match lost(middle) > MOST_LOST {
                true => far = middle,
                false => near = middle,
            }
        }
        Some(format!(
            "the table counts exit directions in bins of {:.3} mrad, which is too coarse from a \
            distance of {far:.0} mm on: at {r_mm} mm an MTF may be off by {here:.3}; bake the \
            table again with --deviations {:.4}",
            1e3 * self.0.grid.bin_width(),
            self.0.advised_mrad()
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tables::deviation::Grid;

    /// A blur exp(-2 (pi s f)^2) that does not grow with the distance, seen through bins of w: the
    /// loss is the difference from the blur itself, and to lowest order it is largest, (R w / s)^2
    /// / (12 e), at the frequency 1 / (sqrt 2 pi s). So 1 % is reached at R = s/w sqrt(0.12 e).
    #[test]
    fn losses_and_distances_of_a_gaussian() {
        let grid = Grid {
            cells: 16,
            bins: 127,
            range: 0.026,
        };
        let (found, width) = (Deviations::new(grid, 1), grid.bin_width());
        let bins = ExitBins(&found);
        for s_mm in [0.1, 0.5, 2.0] {
            let blur = |f: f64| (-2.0 * (PI * s_mm * f).powi(2)).exp();
            let mtf = |r_mm: f64, f: f64| blur(f) * sinc(PI * f * r_mm * width);
            let first_mm = s_mm / width * (0.12 * 1_f64.exp()).sqrt();
            for part in [0.8, 1.0, 1.5, 2.0] {
                let r_mm = part * first_mm;
                let lost = bins.lost(r_mm, |f| mtf(r_mm, f));
                let truth = (1..4000)
                    .map(|k| f64::from(k) * 1e-3 / s_mm)
                    .map(|f| blur(f) - mtf(r_mm, f))
                    .fold(0.0, f64::max);
                // The frequencies of the search are a tenth of that of the maximum apart, which
                // costs 1 % of the loss.
                assert!(
                    (lost / truth - 1.0).abs() < 0.02,
                    "{part}: {lost} for {truth}"
                );
                let said = bins.too_coarse(r_mm, mtf);
                assert!(said.is_some() == (part > 1.0) || part == 1.0, "{part}");
                if let Some(said) = said {
                    let (_, from) = said.split_once("distance of ").expect("a distance");
                    let from = from.split(' ').next().expect("a word").parse::<f64>();
                    // The next order is 3 % of the lowest.
                    let off = from.expect("a number") / first_mm - 1.0;
                    assert!(off.abs() < 0.03, "{off}");
                }
            }
        }
    }
}
