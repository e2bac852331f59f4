//! What a table of rays says of its own error, from its counts.

use crate::tally::Sums;
use tables::{Fate, Table};

/// The sums that a table of rays was made of, direction by direction.
fn sums(table: &Table) -> Vec<Sums> {
    let (Some(counts), Some(fates)) = (&table.counts, &table.fate_counts) else {
        return Vec::new();
    };
    let (incidences, azimuths) = table.axes.shape();
    let of = |i: usize, a: usize| {
        let counts = counts.slice(ndarray::s![i, a, .., .., ..]);
        let fates = fates.slice(ndarray::s![i, a, .., ..]);
        let fates: Vec<[u64; Fate::ALL.len()]> = fates
            .rows()
            .into_iter()
            .map(|row| std::array::from_fn(|fate| row[fate]))
            .collect();
        Sums {
            counts: counts.iter().copied().collect(),
            launched: fates.iter().map(|fates| fates.iter().sum()).collect(),
            fates,
        }
    };
    (0..incidences * azimuths)
        .map(|at| of(at / azimuths, at % azimuths))
        .collect()
}

/// Estimated L1 error of every direction of a table of rays, as `--tolerance` makes it.
pub fn estimates(table: &Table) -> Vec<f64> {
    sums(table).iter().map(Sums::l1_error).collect()
}

/// Returned rays per bin met, in one randomisation; the least over directions, infinite where nothing returns.
pub fn density(table: &Table) -> f64 {
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
    sums(table).iter().map(of).fold(f64::INFINITY, f64::min)
}
