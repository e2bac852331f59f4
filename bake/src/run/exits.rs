//! Exit directions of two tables of one direction of light: how far they are apart, and how far
//! counting explains.
//!
//! A table of rays has counted directions on a grid. An exact table has the direction of every
//! path, and so the exact probability of every bin of such a grid.

use std::collections::BTreeMap;

use tables::deviation::Grid;
use tables::{Path, Table};

use crate::beams::spread;

/// Mean absolute value of a normal variable of unit variance, sqrt(2/pi).
pub(crate) const ABSOLUTE: f64 = 0.797_884_560_802_865_4;

/// Number of standard deviations beyond the mean that counting explains.
///
/// The L1 distance is a sum of |x_k| over the bins, and the x_k are nearly normal with a covariance
/// of at most diag(s_k^2), s_k^2 = p_k / rays. So it is a function of independent normal variables
/// with the Lipschitz constant sqrt(sum of s_k^2), and exceeds its mean by t times that constant
/// with a probability of at most exp(-t^2 / 2) (Borell and Tsirelson): 4e-6 for 5. A thousand
/// directions then fail by chance once in 270 comparisons at most.
const SIGMAS: f64 = 5.0;

/// Distance of a deviation from the border of a bin below which rays may fall on either side, a
/// tangent.
///
/// Directions are made of some ten reflections and two refractions, each rounded to 1e-16; grazing
/// exits enlarge that by 1 / cos(incidence). 1e-12 leaves two digits for it. The bins that `bake`
/// chooses are wider than 1e-8. Narrower bins than four times this are not compared with polygons.
const BORDER: f64 = 1e-12;

/// Difference of the exit directions of two tables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExitGap {
    /// L1 distance of the probabilities of the bins of direction, all shifts taken together.
    pub l1: f64,
    /// Greatest distance that the counting errors of both tables explain.
    pub limit: f64,
}

/// Probabilities of both tables by bin of direction (along v, across).
type Shares = BTreeMap<[usize; 2], [f64; 2]>;

/// Compares the exit directions of two tables in the direction (incidence, azimuth) of these
/// indices.
///
/// Returns `None` unless one table counted them and the other counted them on the same grid or has
/// polygons, and if the bins are narrower than rounding.
pub(crate) fn exits(a: &Table, b: &Table, at: (usize, usize)) -> Option<ExitGap> {
    let grid = match (&a.deviations, &b.deviations) {
        (Some(a), Some(b)) if a.grid != b.grid => return None,
        (Some(found), _) | (None, Some(found)) => found.grid,
        (None, None) => return None,
    };
    if grid.bin_width() < 4.0 * BORDER && (a.exact.is_some() || b.exact.is_some()) {
        return None;
    }
    let mut shares = Shares::new();
    let mut per_ray = 0.0;
    for (k, table) in [a, b].into_iter().enumerate() {
        per_ray += counted(table, at, k, &mut shares).or_else(|| {
            let paths = exact_paths(table, at)?;
            expected(table, paths, &grid, k, &mut shares);
            Some(0.0)
        })?;
    }
    // Rays of one path may fall to both sides of a border: its bins are one.
    for table in [a, b] {
        for path in exact_paths(table, at).unwrap_or_default() {
            join(&mut shares, &bins_of(path, &grid));
        }
    }
    let l1 = shares.values().map(|[a, b]| (a - b).abs()).sum();
    let variance = |&[a, b]: &[f64; 2]| f64::midpoint(a, b) * per_ray;
    let mean: f64 = shares.values().map(|pair| variance(pair).sqrt()).sum();
    let whole: f64 = shares.values().map(variance).sum();
    Some(ExitGap {
        l1,
        limit: ABSOLUTE * mean + SIGMAS * whole.sqrt() + 1e-9,
    })
}

/// Adds the rays that a table counted as probabilities, as its `k`-th of both. Returns the
/// probability of one ray, or `None` if the table did not count directions.
fn counted(table: &Table, (i, j): (usize, usize), k: usize, shares: &mut Shares) -> Option<f64> {
    let found = table.deviations.as_ref()?;
    let rays = table.rays[[i, j]] as f64;
    if rays == 0.0 {
        return None;
    }
    for entry in found.entries.get(i * table.axes.shape().1 + j)? {
        let (_, bin) = found.grid.at(entry.place);
        shares.entry(bin).or_default()[k] += entry.rays as f64 / rays;
    }
    Some(1.0 / rays)
}

/// Returns the paths of an exact table in one direction.
fn exact_paths(table: &Table, (i, j): (usize, usize)) -> Option<&[Path]> {
    (!table.axes.is_mean()).then_some(())?;
    let exact = table.exact.as_ref()?;
    let paths = exact.paths.get(i * table.axes.shape().1 + j)?;
    Some(paths)
}

/// Adds the probability of each path of an exact table to the bin of its direction.
///
/// Rays are counted by direction if their shift is in the histogram, so the rest is left out here.
fn expected(table: &Table, paths: &[Path], grid: &Grid, k: usize, shares: &mut Shares) {
    let area = table
        .exact
        .as_ref()
        .map_or(0.0, |exact| exact.entrance_area);
    for path in paths {
        let (inside, _) = spread(std::slice::from_ref(path), area, 1, table.axes.range);
        let [across, along] = path.deviation.map(|tangent| grid.bin(tangent));
        shares.entry([along, across]).or_default()[k] += inside.iter().sum::<f64>();
    }
}

/// Returns the bins that the rays of a path may fall into: one, or two or four at a border.
fn bins_of(path: &Path, grid: &Grid) -> Vec<[usize; 2]> {
    let sides = |tangent: f64| [-BORDER, BORDER].map(|off| grid.bin(tangent + off));
    let [across, along] = path.deviation.map(sides);
    let mut bins: Vec<[usize; 2]> = along
        .into_iter()
        .flat_map(|along| across.map(|across| [along, across]))
        .collect();
    bins.sort_unstable();
    bins.dedup();
    bins
}

/// Moves what all these bins hold to the first of them.
///
/// Two borders of one bin would need a further step, but no two paths are that close to both.
fn join(shares: &mut Shares, bins: &[[usize; 2]]) {
    let Some((first, others)) = bins.split_first() else {
        return;
    };
    for bin in others {
        if let Some([a, b]) = shares.remove(bin) {
            let sum = shares.entry(*first).or_default();
            *sum = [sum[0] + a, sum[1] + b];
        }
    }
}
