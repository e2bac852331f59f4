//! Error estimate and density of a table of rays, from its counts alone.

use crate::rays::Sums;
use tables::Table;

/// Returns the estimated L1 error of every direction of a table of rays.
///
/// `bake trace --tolerance` makes the same estimate.
pub(crate) fn estimates(table: &Table) -> Vec<f64> {
    Sums::of_table(table).iter().map(Sums::l1_error).collect()
}

/// Returns the mean number of retroreflected rays per bin that any ray met, in one randomisation.
///
/// It is the least over all directions. A direction in which nothing returns counts as infinite.
pub(crate) fn density(table: &Table) -> f64 {
    let of = |sums: &Sums| {
        let randomisations = sums.launched.len().max(1);
        let size = sums.counts.len() / randomisations;
        let met = (0..size)
            .filter(|bin| (0..randomisations).any(|r| sums.counts[r * size + bin] > 0))
            .count();
        let returned: u64 = sums.counts.iter().sum();
        if met == 0 {
            f64::INFINITY
        } else {
            returned as f64 / (met * randomisations) as f64
        }
    };
    Sums::of_table(table)
        .iter()
        .map(of)
        .fold(f64::INFINITY, f64::min)
}
