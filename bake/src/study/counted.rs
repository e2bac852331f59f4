//! What a table of rays says of its own error, from its counts.

use crate::rays::Sums;
use tables::Table;

/// Estimated L1 error of every direction of a table of rays, as `--tolerance` makes it.
pub(crate) fn estimates(table: &Table) -> Vec<f64> {
    Sums::of_table(table).iter().map(Sums::l1_error).collect()
}

/// Returned rays per bin met, in one randomisation; the least over directions, infinite where
/// nothing returns.
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
