//! Two tables, direction by direction: by how much they differ, and whether their errors explain
//! it.

use tables::Table;

/// Standard errors by which two retroreflected fractions may differ.
const SIGMAS: f64 = 4.0;

/// Two tables of the same axes, direction by direction.
pub struct Comparison {
    /// The directions, incidence slow, azimuth fast.
    pub rows: Vec<Row>,
}

/// What two tables differ by in one direction.
pub struct Row {
    /// Degrees.
    pub incidence_deg: f64,
    /// Degrees; NaN for the mean over all.
    pub azimuth_deg: f64,
    /// Sum over the bins of the differences of probability.
    pub l1: f64,
    /// The largest of them.
    pub largest: f64,
    /// Difference of the retroreflected fractions in standard errors; 0 where they are equal.
    pub sigmas: f64,
    /// The L1 distance that the counting errors of both tables explain.
    pub noise: f64,
}

impl Comparison {
    /// Compares two tables.
    ///
    /// # Errors
    /// Which of their axes differ.
    pub fn new(a: &Table, b: &Table) -> Result<Self, &'static str> {
        // NaN (the mean over azimuths) equals itself here.
        let same = |a: &[f64], b: &[f64]| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
        };
        if !same(&a.axes.incidence_deg, &b.axes.incidence_deg) {
            return Err("the incidence angles differ");
        }
        if !same(&a.axes.azimuth_deg, &b.axes.azimuth_deg) {
            return Err("the azimuths differ");
        }
        if (a.axes.bins, a.axes.range.to_bits()) != (b.axes.bins, b.axes.range.to_bits()) {
            return Err("the histogram bins differ");
        }
        Ok(Comparison::of(a, b))
    }

    /// Compares two tables of the same axes.
    pub(crate) fn of(a: &Table, b: &Table) -> Self {
        let row = |((i, j), &eta): ((usize, usize), &f64)| {
            let (pa, pb) = (a.probability(i, j), b.probability(i, j));
            let difference = (&pa - &pb).mapv(f64::abs);
            let gap = (eta - b.retroreflected[[i, j]]).abs();
            // Random counts: a bin of probability p differs by sqrt(2/pi) sqrt(p/na + p/nb) on
            // average. A low-discrepancy sequence stays below.
            let share = |rays: u64| if rays == 0 { 0.0 } else { 1.0 / rays as f64 };
            let per_ray = share(a.rays[[i, j]]) + share(b.rays[[i, j]]);
            // Where all rays or none came back the standard error is 0, but the fraction is known
            // to one ray only.
            let error = a.standard_error[[i, j]]
                .hypot(b.standard_error[[i, j]])
                .max(per_ray);
            let root = |(&pa, &pb): (&f64, &f64)| (f64::midpoint(pa, pb) * per_ray).sqrt();
            Row {
                incidence_deg: a.axes.incidence_deg[i],
                azimuth_deg: a.axes.azimuth_deg[j],
                l1: difference.sum(),
                largest: difference.iter().copied().fold(0.0, f64::max),
                sigmas: if gap <= 1e-12 { 0.0 } else { gap / error },
                noise: (2.0 / std::f64::consts::PI).sqrt()
                    * pa.iter().zip(&pb).map(root).sum::<f64>(),
            }
        };
        Comparison {
            rows: a.retroreflected.indexed_iter().map(row).collect(),
        }
    }

    /// Whether every direction agrees: the fractions within 4 standard errors, the histograms
    /// within 1.5 times the mean counting noise (or to 1e-9, where there is none).
    pub fn agrees(&self) -> bool {
        self.rows.iter().all(Row::agrees)
    }
}

impl Row {
    /// Whether the fractions are within 4 standard errors and the histograms within 1.5 times the
    /// mean counting noise.
    pub fn agrees(&self) -> bool {
        self.sigmas <= SIGMAS && self.l1 <= 1.5 * self.noise + 1e-9
    }
}
