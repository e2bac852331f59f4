//! Paths of exact tables: whether they give the table's own histogram, and how far two lists of
//! them are apart.
//!
//! `fit` computes with the polygons, and a person looks at the histogram. A table whose polygons
//! were changed and sealed again keeps its histogram, so the one is computed from the other.

use tables::{Fate, Path, Table};
use thiserror::Error;

use crate::beams::spread;

/// Largest difference of two polygons, maps, weights or deviations that agree.
///
/// They are made of some hundred sums and products of numbers of a few edge lengths, each rounded
/// to 2^-53, and are enlarged where facets meet at small angles; 1e-9 leaves four digits for that.
pub(crate) const SAME: f64 = 1e-9;

/// Longest lists of which the order does not matter, paths; a direction of a sheet has some tens.
pub(crate) const MOST_PAIRED: usize = 4096;

/// Difference below which lists are taken to be in the same order.
const NEAR: f64 = 1e-6;

/// Polygons that do not give what the table states.
#[derive(Debug, Clone, PartialEq, Error)]
#[error(
    "the polygons at incidence {incidence_deg} and azimuth {azimuth_deg} degrees do not give the \
    table's {what}: they are off by {off:.1e}, rounding explains {allowed:.1e}"
)]
pub struct Forged {
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Azimuth, degrees.
    pub azimuth_deg: f64,
    /// Quantity that differs.
    pub what: &'static str,
    /// L1 distance of the histograms, or difference of the fractions.
    pub off: f64,
    /// Greatest value that rounding explains.
    pub allowed: f64,
}

/// Checks that the polygons of an exact table give its histogram and its fates.
///
/// Eta and the corners were checked when the table was read. Tables without polygons, and means
/// over azimuths, pass.
///
/// # Errors
/// Returns [`Forged`] for the first direction whose polygons give something else.
pub fn consistent(table: &Table) -> Result<(), Forged> {
    let Some(exact) = table.exact.as_ref().filter(|_| !table.axes.is_mean()) else {
        return Ok(());
    };
    let axes = &table.axes;
    let (_, azimuths) = axes.shape();
    // A bin is a running sum over a row, so of up to `bins` terms below 1, each rounded to 2^-53;
    // there are bins^2 of them. 1e-9 is what sums of a table may be off.
    let allowed = 1e-9 + (axes.bins as f64).powi(3) * f64::EPSILON;
    for (direction, paths) in exact.paths.iter().enumerate() {
        let (i, j) = (direction / azimuths, direction % azimuths);
        let (mass, outside) = spread(paths, exact.entrance_area, axes.bins, axes.range);
        let whole: f64 = mass.iter().sum();
        let scale = if whole > 0.0 { 1.0 / whole } else { 0.0 };
        let stored = table.histogram.index_axis(ndarray::Axis(0), i);
        let stored = stored.index_axis(ndarray::Axis(0), j);
        let l1: f64 = mass
            .iter()
            .zip(&stored)
            .map(|(mass, stored)| (mass * scale - stored).abs())
            .sum();
        let fate = |fate: Fate| table.fate[[i, j, fate as usize]];
        let inside = table.retroreflected[[i, j]] - outside;
        let found = [
            ("histogram", l1),
            (
                "fate out_of_range",
                (outside - fate(Fate::OutOfRange)).abs(),
            ),
            (
                "fate retroreflected",
                (inside.max(0.0) - fate(Fate::Retroreflected)).abs(),
            ),
        ];
        for (what, off) in found {
            if off > allowed || off.is_nan() {
                return Err(Forged {
                    incidence_deg: axes.incidence_deg[i],
                    azimuth_deg: axes.azimuth_deg[j],
                    what,
                    off,
                    allowed,
                });
            }
        }
    }
    Ok(())
}

/// Returns the largest difference between the paths of two directions; infinite if a path has no
/// counterpart.
///
/// The order of the paths does not matter, up to [`MOST_PAIRED`] of them.
pub(crate) fn apart(a: &[Path], b: &[Path]) -> f64 {
    if a.len() != b.len() {
        return f64::INFINITY;
    }
    let in_order = a.iter().zip(b).map(|(p, q)| between(p, q));
    let in_order = in_order.fold(0.0, f64::max);
    if a.len() > MOST_PAIRED || in_order <= NEAR {
        return in_order;
    }
    let mut left: Vec<&Path> = b.iter().collect();
    let mut largest = 0.0_f64;
    for path in a {
        let nearest = left
            .iter()
            .enumerate()
            .map(|(k, other)| (between(path, other), k))
            .min_by(|p, q| p.0.total_cmp(&q.0));
        if let Some((distance, k)) = nearest {
            left.swap_remove(k);
            largest = largest.max(distance);
        }
    }
    largest
}

/// Returns the largest difference between the numbers of two paths; infinite if their polygons have
/// other numbers of corners, or if passes or Jones matrices differ.
fn between(p: &Path, q: &Path) -> f64 {
    if p.polygon.len() != q.polygon.len() || p.passes != q.passes || p.jones != q.jones {
        return f64::INFINITY;
    }
    let pairs = |a: &[[f64; 2]], b: &[[f64; 2]]| {
        let differences = a.as_flattened().iter().zip(b.as_flattened());
        differences.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    [
        pairs(&p.polygon, &q.polygon),
        pairs(&p.matrix, &q.matrix),
        pairs(&[p.offset, p.deviation], &[q.offset, q.deviation]),
        (p.weight - q.weight).abs(),
    ]
    .into_iter()
    .fold(0.0, f64::max)
}
