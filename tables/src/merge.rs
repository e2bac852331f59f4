//! Adding the rays of tables.
//!
//! A table of seed `s` with `R` randomisations stands for the seeds `s .. s + R`, one for each randomisation.
//! Two merges follow from that:
//! - **more rays** ([`merge()`]): ranges of seeds that follow one another are put side by side along the
//!   randomisation axis. The result is that of one bake with the first seed and all the randomisations.
//! - **shards of one bake** ([`merge()`] where they are of different directions or randomisations,
//!   [`merge_shards`] where they are blocks of the samples): counts of the same seed are added place by place.
//!
//! Both are sums of integers, so the order and the grouping of the merges do not change a bit.

use ndarray::{Axis, Zip, concatenate};

use crate::error::Error;
use crate::table::Table;

/// Why tables cannot be merged. Indices are positions in the list given.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Mismatch {
    /// Nothing to merge.
    #[error("no table to merge; name at least one")]
    Empty,
    /// A table without counts.
    #[error(
        "table {index} holds no counts of rays (method {method:?}); an exact table has nothing to add, use it as it is"
    )]
    NoCounts {
        /// Which table.
        index: usize,
        /// Its method.
        method: String,
    },
    /// A field that says what was baked is not the same.
    #[error(
        "{field} of table {index} is {found}, that of the first is {expected}; merge tables of one design only"
    )]
    Field {
        /// Name of the field, as in the file.
        field: &'static str,
        /// Which table.
        index: usize,
        /// Value in the first table.
        expected: String,
        /// Value in this one.
        found: String,
    },
    /// Both tables hold rays of the same seed, randomisation and direction.
    #[error(
        "tables {first} and {second} both hold rays of seed {seed} at direction {direction:?}, which would be counted \
         twice; bake one of them with another --seed"
    )]
    Overlap {
        /// One table.
        first: usize,
        /// The other.
        second: usize,
        /// The seed.
        seed: u64,
        /// Index along incidence and azimuth.
        direction: (usize, usize),
    },
    /// The ranges of seeds do not follow one another.
    #[error(
        "table {index} has seed {found}, expected {expected}, the one after the seeds of the other tables; bake it \
         with --seed {expected}"
    )]
    Seed {
        /// Which table.
        index: usize,
        /// The seed that would continue the range.
        expected: u64,
        /// The seed of the table.
        found: u64,
    },
}

/// Adds the rays of tables of one design: shards of one seed, and bakes of seeds that follow one another.
///
/// The order of the list does not matter. Tables of the same seed may hold different directions or
/// randomisations, not the same ones: whether those are other samples or the same again cannot be told (see
/// [`merge_shards`]).
///
/// # Errors
/// [`Error::Merge`] with the field that differs, the overlap, or the seed that is needed.
pub fn merge(tables: &[Table]) -> Result<Table, Error> {
    combine(tables, false)
}

/// As [`merge()`], where the caller vouches that tables of one seed hold different samples of it.
///
/// # Errors
/// As [`merge()`], without [`Mismatch::Overlap`].
pub fn merge_shards(tables: &[Table]) -> Result<Table, Error> {
    combine(tables, true)
}

fn combine(tables: &[Table], disjoint: bool) -> Result<Table, Error> {
    let first = tables.first().ok_or(Mismatch::Empty)?;
    for (index, table) in tables.iter().enumerate() {
        same(first, table, index)?;
    }
    let mut order: Vec<usize> = (0..tables.len()).collect();
    order.sort_by_key(|&index| tables[index].provenance.seed);
    // One entry per seed: the sum, and which tables are in it.
    let mut ranges: Vec<(Table, Vec<usize>)> = Vec::new();
    for index in order {
        let table = &tables[index];
        match ranges.last_mut() {
            Some((sum, members)) if sum.provenance.seed == table.provenance.seed => {
                if !disjoint {
                    overlap(tables, members, index)?;
                }
                add(sum, table, index)?;
                members.push(index);
            }
            _ => ranges.push((table.clone(), vec![index])),
        }
    }
    let seed = ranges[0].0.provenance.seed;
    let mut expected = seed;
    for (table, members) in &ranges {
        let found = table.provenance.seed;
        if found != expected {
            return Err(Mismatch::Seed {
                index: members[0],
                expected,
                found,
            }
            .into());
        }
        expected = expected.wrapping_add(randomisations(table) as u64);
    }
    let counts: Vec<_> = ranges
        .iter()
        .filter_map(|(table, _)| table.counts.as_ref())
        .map(|c| c.view())
        .collect();
    let fates: Vec<_> = ranges
        .iter()
        .filter_map(|(table, _)| table.fate_counts.as_ref())
        .map(|c| c.view())
        .collect();
    let (Ok(counts), Ok(fates)) = (concatenate(Axis(2), &counts), concatenate(Axis(2), &fates))
    else {
        unreachable!("equal axes give equal shapes but for the randomisations");
    };
    let mut provenance = first.provenance.clone();
    provenance.seed = seed;
    // `concatenate` leaves a layout of its own.
    let (counts, fates) = (
        counts.as_standard_layout().into_owned(),
        fates.as_standard_layout().into_owned(),
    );
    Ok(Table::from_counts(
        first.axes.clone(),
        counts,
        fates,
        provenance,
    ))
}

fn randomisations(table: &Table) -> usize {
    table.counts.as_ref().map_or(0, |counts| counts.shape()[2])
}

/// Compares everything that says what was baked; only the seed may differ.
fn same(first: &Table, table: &Table, index: usize) -> Result<(), Mismatch> {
    if table.counts.is_none() || table.fate_counts.is_none() {
        return Err(Mismatch::NoCounts {
            index,
            method: table.provenance.method.clone(),
        });
    }
    macro_rules! compare {
        ($($part:ident . $field:ident = $name:literal),* $(,)?) => {
            $(if first.$part.$field != table.$part.$field {
                return Err(Mismatch::Field {
                    field: $name,
                    index,
                    expected: format!("{:?}", first.$part.$field),
                    found: format!("{:?}", table.$part.$field),
                });
            })*
        };
    }
    compare!(
        provenance.design = "design",
        provenance.mesh_hash = "mesh_hash",
        provenance.edge_length = "edge_length",
        provenance.edge_length_unit = "edge_length_unit",
        provenance.azimuth_zero = "azimuth_zero",
        provenance.refractive_index = "refractive_index",
        provenance.back = "back",
        provenance.losses = "losses",
        provenance.reflectance = "reflectance",
        provenance.method = "method",
        provenance.sampler = "sampler",
        provenance.angular_tolerance_deg = "angular_tolerance_deg",
        provenance.tolerance = "tolerance",
        provenance.lattice = "lattice",
        provenance.generator = "generator",
        axes.incidence_deg = "incidence_deg",
        axes.bins = "bins",
        axes.range = "shift_range",
    );
    // The NaN azimuth of a mean equals itself in `Axes` only.
    if first.axes != table.axes {
        return Err(Mismatch::Field {
            field: "azimuth_deg",
            index,
            expected: format!("{:?}", first.axes.azimuth_deg),
            found: format!("{:?}", table.axes.azimuth_deg),
        });
    }
    Ok(())
}

/// Refuses rays of one seed, randomisation and direction in two tables.
fn overlap(tables: &[Table], members: &[usize], second: usize) -> Result<(), Mismatch> {
    let launched = |table: &Table| {
        table
            .fate_counts
            .as_ref()
            .map(|fates| fates.sum_axis(Axis(3)))
    };
    for &first in members {
        let (Some(a), Some(b)) = (launched(&tables[first]), launched(&tables[second])) else {
            continue;
        };
        for ((i, j, r), &rays) in a.indexed_iter() {
            if rays > 0 && b.get((i, j, r)).is_some_and(|&rays| rays > 0) {
                let seed = tables[first].provenance.seed.wrapping_add(r as u64);
                return Err(Mismatch::Overlap {
                    first,
                    second,
                    seed,
                    direction: (i, j),
                });
            }
        }
    }
    Ok(())
}

fn add(sum: &mut Table, table: &Table, index: usize) -> Result<(), Mismatch> {
    let (expected, found) = (randomisations(sum), randomisations(table));
    if expected != found {
        let (expected, found) = (expected.to_string(), found.to_string());
        return Err(Mismatch::Field {
            field: "randomisation",
            index,
            expected,
            found,
        });
    }
    if let (Some(counts), Some(more)) = (&mut sum.counts, &table.counts) {
        Zip::from(counts).and(more).for_each(|n, more| *n += more);
    }
    if let (Some(fates), Some(more)) = (&mut sum.fate_counts, &table.fate_counts) {
        Zip::from(fates).and(more).for_each(|n, more| *n += more);
    }
    Ok(())
}
