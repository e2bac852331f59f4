//! Comparison of two tables, direction by direction.
//!
//! It says how much the tables differ, and whether their errors explain the difference. Of two
//! exact tables the polygons are compared, because `fit` computes with them and not with the
//! histogram: path by path, and where the paths are cut differently, by their regions. Exit
//! directions are compared where at least one of the tables counted them.

use crate::run::cuts::uncut;
use crate::run::exits::{ABSOLUTE, ExitGap, exits};
use crate::run::paths::{SAME, apart};
use ndarray::{Array2, s};
use tables::{Fate, Table};

/// Number of standard errors by which two retroreflected fractions may differ.
const SIGMAS: f64 = 4.0;

/// Comparison of two tables with equal axes, direction by direction.
pub struct Comparison {
    /// Differences of the tables by direction, incidence slow, azimuth fast.
    pub rows: Vec<Row>,
}

/// Difference of two tables in one direction.
pub struct Row {
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Azimuth, degrees; NaN for the mean over all azimuths.
    pub azimuth_deg: f64,
    /// Sum over the bins of the absolute differences of probability (L1 distance).
    pub l1: f64,
    /// Largest absolute difference of probability of a bin.
    pub largest: f64,
    /// Difference of the retroreflected fractions in standard errors; 0 if they are equal.
    pub sigmas: f64,
    /// L1 distance that the counting errors of both tables explain.
    pub noise: f64,
    /// Difference of the light of two exact tables; `None` unless both have polygons of this
    /// direction.
    ///
    /// It is the largest difference of their polygons, maps, weights and deviations, path by path,
    /// or, if that is less, the mean distance of the outlines of equal light, edge lengths. The
    /// latter does not depend on the polygons into which a region is cut.
    pub paths: Option<f64>,
    /// Difference of the exit directions; `None` unless one table counted them and the other
    /// counted them on the same grid or has polygons.
    pub exits: Option<ExitGap>,
}

impl Comparison {
    /// Compares two tables.
    ///
    /// # Errors
    /// Returns a sentence that names the axis if the two tables differ in their incidences, their
    /// azimuths or their histogram bins.
    pub fn new(a: &Table, b: &Table) -> Result<Self, &'static str> {
        // Bits are compared, so that NaN (the mean over azimuths) equals itself.
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

    /// Compares two tables whose axes are known to be equal.
    pub(crate) fn of(a: &Table, b: &Table) -> Self {
        let row = |((i, j), &eta): ((usize, usize), &f64)| {
            let (pa, pb) = (in_range(a, (i, j)), in_range(b, (i, j)));
            let difference = (&pa - &pb).mapv(f64::abs);
            let gap = (eta - b.retroreflected[[i, j]]).abs();
            // Of random counts, a bin of probability p differs by [`ABSOLUTE`] sqrt(p/na + p/nb)
            // on average. Counts of a low-discrepancy sequence differ less.
            let share = |rays: u64| if rays == 0 { 0.0 } else { 1.0 / rays as f64 };
            let per_ray = share(a.rays[[i, j]]) + share(b.rays[[i, j]]);
            // Where all rays came back, or none, the standard error is 0. But the fraction is known
            // no better than to one ray.
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
                noise: ABSOLUTE * pa.iter().zip(&pb).map(root).sum::<f64>(),
                paths: paths(a, b, (i, j)),
                exits: exits(a, b, (i, j)),
            }
        };
        Comparison {
            rows: a.retroreflected.indexed_iter().map(row).collect(),
        }
    }

    /// Returns whether the two tables agree in every direction.
    ///
    /// [`Row::agrees`] says what that means.
    pub fn agrees(&self) -> bool {
        self.rows.iter().all(Row::agrees)
    }
}

impl Row {
    /// Returns whether the two tables agree in this direction.
    ///
    /// They agree if the fractions are within 4 standard errors, the histograms within 1.5 times
    /// the mean counting noise (or to 1e-9, where there is no noise), the exit directions within
    /// [`ExitGap::limit`], and polygons to 1e-9.
    pub fn agrees(&self) -> bool {
        self.sigmas <= SIGMAS
            && self.l1 <= 1.5 * self.noise + 1e-9
            && self.paths.is_none_or(|apart| apart <= SAME)
            && self.exits.is_none_or(|gap| gap.l1 <= gap.limit)
    }
}

/// Returns the probability per launched ray of each bin, `[v, u]`.
///
/// [`Table::probability`] spreads light that is out of range over the bins. Its counts have no
/// noise there, so a comparison leaves it out.
fn in_range(table: &Table, (i, j): (usize, usize)) -> Array2<f64> {
    let share = table.fate[[i, j, Fate::Retroreflected as usize]];
    table.histogram.slice(s![i, j, .., ..]).mapv(|p| p * share)
}

/// Returns how far the light of two exact tables is apart in one direction.
fn paths(a: &Table, b: &Table, (i, j): (usize, usize)) -> Option<f64> {
    let at = i * a.axes.shape().1 + j;
    let of = |table: &Table| Some(table.exact.as_ref()?.paths.get(at)?.clone());
    (!a.axes.is_mean()).then_some(())?;
    let (a, b) = (of(a)?, of(b)?);
    let in_pairs = apart(&a, &b);
    Some(if in_pairs <= SAME {
        in_pairs
    } else {
        in_pairs.min(uncut(&a, &b))
    })
}
