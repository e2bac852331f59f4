//! Adding the rays and the directions of tables.
//!
//! A table of seed `s` with `R` randomisations stands for the seeds `s .. s + R`, one for each
//! randomisation. Tables of one cell are merged in three ways, all of them at once if necessary:
//!
//! - **Shards** of one bake are equal shares of its samples ([`Shards`]). Counts are added place by
//!   place.
//! - **Directions** are put side by side. Samples depend on the angles, not on their place in a
//!   list, so the result is a bake of all directions.
//! - **Seeds** that follow one another are put side by side along the randomisation axis. The
//!   result is a bake of the first seed with all the randomisations.
//!
//! All are sums of integers, so the order and the grouping of the merges do not change a bit.

use std::collections::BTreeSet;
use std::fmt::Display;

use ndarray::{Axis, Zip, concatenate};

use crate::error::Error;
use crate::merge::directions::{join, place, spread, union};
use crate::table::axes::Axes;
use crate::table::deviation;
use crate::table::deviation::Deviations;
use crate::table::provenance::level;
use crate::table::shards::Shards;
use crate::table::table::Table;

/// Merges tables of one cell; the order of the list does not matter.
///
/// The shards of a bake, or tables of its directions, give the table of the whole bake, bit for
/// bit. Exact tables have no rays to add; only their directions are joined.
///
/// ```
/// # use std::path::Path;
/// let table = tables::read(Path::new("tests/kept/version_1_rays.h5"))?;
/// // A bake of as many rays with the next seeds: 16 randomisations take 16 seeds.
/// let mut more = table.clone();
/// more.provenance.seed += 16;
/// let both = tables::merge(&[table.clone(), more])?;
/// assert_eq!(both.rays[[0, 0]], 2 * table.rays[[0, 0]]);
/// let error = tables::merge(&[table.clone(), table]).unwrap_err();
/// assert!(matches!(error, tables::Error::Merge { .. }));
/// # Ok::<(), tables::Error>(())
/// ```
///
/// # Errors
/// Returns [`Error::Merge`] if the list is empty, if the tables differ in a field that says what
/// was baked, if two of them hold the same rays, or if a direction, a seed or a shard is missing.
/// The error names the field, the tables or the missing part.
pub fn merge(tables: &[Table]) -> Result<Table, Error> {
    let first = tables.first().ok_or_else(none)?;
    for (index, table) in tables.iter().enumerate() {
        same(first, table, index)?;
    }
    let mut merged = put_together(tables)?;
    let generator = |table: &Table| table.provenance.generator.clone();
    if tables
        .iter()
        .any(|table| generator(table) != generator(first))
    {
        merged.provenance.generator = level(&generator(first)).to_owned();
    }
    Ok(merged)
}

/// Makes the error of an empty list.
fn none() -> Error {
    Error::Merge {
        fault: "no table to merge".into(),
        remedy: "name at least one".into(),
    }
}

/// Makes the error of a field that differs between tables.
pub(crate) fn differs(
    field: &str,
    index: usize,
    expected: impl Display,
    found: impl Display,
) -> Error {
    Error::Merge {
        fault: format!("{field} of table {index} is {found}, that of the first is {expected}"),
        remedy: match field {
            "generator" => "bake the table of the lower number again: other rules made it",
            _ => "merge tables of one design and method only",
        }
        .into(),
    }
}

/// Makes the error of rays that two tables both hold.
pub(crate) fn overlap(first: usize, second: usize, what: &str, direction: (usize, usize)) -> Error {
    Error::Merge {
        fault: format!(
            "tables {first} and {second} both hold {what} at direction {direction:?}, which would \
            be counted twice"
        ),
        remedy: "leave one of them out, or bake it with another --seed".into(),
    }
}

/// Makes the error of a direction that is missing from the grid of all incidences and azimuths.
pub(crate) fn gap(incidence_deg: f64, azimuth_deg: f64, seed: u64) -> Error {
    Error::Merge {
        fault: format!(
            "no table holds incidence {incidence_deg} deg, azimuth {azimuth_deg} deg of seed \
            {seed}, but the merged table needs it"
        ),
        remedy: "bake this direction too".into(),
    }
}

/// Merges tables that agree in all that says what was baked.
fn put_together(tables: &[Table]) -> Result<Table, Error> {
    let first = &tables[0];
    if tables.len() == 1 {
        return Ok(first.clone());
    }
    let axes = union(tables);
    if first.counts.is_none() {
        return join(tables, axes);
    }
    let mut seeds: Vec<u64> = tables.iter().map(|table| table.provenance.seed).collect();
    seeds.sort_unstable();
    seeds.dedup();
    let ranges = seeds
        .iter()
        .map(|&seed| of_one_seed(tables, &axes, seed))
        .collect::<Result<Vec<Table>, Error>>()?;
    if let [only] = &ranges[..] {
        return Ok(only.clone());
    }
    side_by_side(tables, &ranges)
}

/// Compares all fields that say what was baked; seed, shards and directions may differ.
fn same(first: &Table, table: &Table, index: usize) -> Result<(), Error> {
    macro_rules! compare {
        ($($name:literal = |$table:ident| $value:expr),* $(,)?) => {
            $({
                let [expected, found] = [first, table].map(|$table| $value);
                if expected != found {
                    let [expected, found] = [expected, found].map(|value| format!("{value:?}"));
                    return Err(differs($name, index, expected, found));
                }
            })*
        };
    }
    compare!(
        "design" = |t| &t.provenance.design,
        "mesh_hash" = |t| &t.provenance.mesh_hash,
        "edge_length" = |t| &t.provenance.edge_length,
        "edge_length_unit" = |t| &t.provenance.edge_length_unit,
        "azimuth_zero" = |t| &t.provenance.azimuth_zero,
        "refractive_index" = |t| &t.provenance.refractive_index,
        "back" = |t| t.provenance.back.text(),
        "losses" = |t| t.provenance.losses.text(),
        "reflectance" = |t| &t.provenance.reflectance,
        "method" = |t| t.provenance.method.text(),
        "sampler" = |t| t.provenance.sampler_text(),
        "angular_tolerance_deg" = |t| &t.provenance.angular_tolerance_deg,
        "tolerance" = |t| &t.provenance.tolerance,
        "lattice" = |t| &t.provenance.lattice,
        "symmetry" = |t| &t.provenance.symmetry,
        "wavelength_nm" = |t| &t.provenance.wavelength_nm,
        "metal_index" = |t| &t.provenance.metal_index,
        "options" = |t| t.provenance.options.text(),
        "generator" = |t| level(&t.provenance.generator),
        "fate_name" = |t| t.fates().last().map(|fate| fate.name()),
        "bins" = |t| t.axes.bins,
        "shift_range" = |t| t.axes.range,
    );
    let grid = |table: &Table| table.deviations.as_ref().map(|found| found.grid);
    if grid(first) != grid(table) {
        let [expected, found] = [first, table].map(|table| format!("{:?}", grid(table)));
        return Err(differs("deviation", index, expected, found));
    }
    let kind = |table: &Table| match (&table.counts, table.axes.is_mean()) {
        (Some(_), false) => "single directions, counts of rays",
        (Some(_), true) => "a mean, counts of rays",
        (None, _) => "no counts of rays",
    };
    if kind(first) != kind(table) {
        return Err(differs("azimuths", index, kind(first), kind(table)));
    }
    Ok(())
}

/// Returns the sum of all tables that start at `seed`, on the axes `axes`.
fn of_one_seed(tables: &[Table], axes: &Axes, seed: u64) -> Result<Table, Error> {
    let mut sum: Option<Table> = None;
    // Contents of each direction: the tables that brought rays, each with its shards (`None`: a
    // whole bake).
    let (incidences, azimuths) = axes.shape();
    let mut held: Vec<Vec<(usize, Option<&Shards>)>> = vec![Vec::new(); incidences * azimuths];
    for (index, table) in tables.iter().enumerate() {
        if table.provenance.seed != seed {
            continue;
        }
        let shards = table.provenance.shards.as_ref();
        for (direction, held) in held.iter_mut().enumerate() {
            let direction = (direction / azimuths, direction % azimuths);
            let Some(own) = place(table, axes, direction) else {
                continue;
            };
            for &(first, other) in held.iter() {
                let what = match (other, shards) {
                    (Some(a), Some(b)) if (a.of, a.rays) != (b.of, b.rays) => {
                        return Err(differs("shards", index, a, b));
                    }
                    (Some(a), Some(b)) => a
                        .held
                        .intersection(&b.held)
                        .next()
                        .map(|k| format!("shard {k} of seed {seed}")),
                    _ => place(&tables[first], axes, direction)
                        .and_then(|there| {
                            shared_randomisation((&tables[first], there), (table, own))
                        })
                        .map(|r| format!("rays of seed {}", seed.wrapping_add(r))),
                };
                if let Some(what) = what {
                    return Err(overlap(first, index, &what, direction));
                }
            }
            held.push((index, shards));
        }
        let more = spread(table, axes);
        match &mut sum {
            None => sum = Some(more),
            Some(sum) => add(sum, &more, index)?,
        }
    }
    let mut sum = sum.ok_or_else(none)?;
    sum.provenance.shards = together(&held, axes, seed)?;
    Ok(rebuilt(sum))
}

/// Returns the shards that every direction holds in sum; `None` for the whole bake.
fn together(
    held: &[Vec<(usize, Option<&Shards>)>],
    axes: &Axes,
    seed: u64,
) -> Result<Option<Shards>, Error> {
    let sum = |parts: &[(usize, Option<&Shards>)]| {
        let mut shards = parts.iter().filter_map(|(_, shards)| *shards);
        let first = shards.next()?.clone();
        let held: BTreeSet<u32> = shards.fold(first.held, |held, more| &held | &more.held);
        Some(Shards { held, ..first }).filter(Shards::is_valid)
    };
    let azimuths = axes.azimuth_deg.len();
    let expected = sum(&held[0]);
    let named = |shards: &Option<Shards>| -> String {
        shards
            .as_ref()
            .map_or("the whole bake".into(), |s| format!("shards {s}"))
    };
    for (direction, parts) in held.iter().enumerate() {
        let incidence_deg = axes.incidence_deg[direction / azimuths];
        let azimuth_deg = axes.azimuth_deg[direction % azimuths];
        if parts.is_empty() {
            return Err(gap(incidence_deg, azimuth_deg, seed));
        }
        let found = sum(parts);
        if found != expected {
            let [expected, found] = [&expected, &found].map(named);
            return Err(Error::Merge {
                fault: format!(
                    "the tables of seed {seed} hold {found} at incidence {incidence_deg} deg, \
                    azimuth {azimuth_deg} deg, but {expected} at the first direction"
                ),
                remedy: "give the same shards for every direction".into(),
            });
        }
    }
    Ok(expected)
}

/// Returns a randomisation of which both tables hold rays, each at its own place of one direction.
fn shared_randomisation(a: (&Table, (usize, usize)), b: (&Table, (usize, usize))) -> Option<u64> {
    let rays = |(table, (i, j)): (&Table, (usize, usize)), r: usize| -> u64 {
        let fates = table.fate_counts.as_ref();
        fates.map_or(0, |fates| fates.slice(ndarray::s![i, j, r, ..]).sum())
    };
    let both = randomisations(a.0).min(randomisations(b.0));
    (0..both)
        .find(|&r| rays(a, r) > 0 && rays(b, r) > 0)
        .map(|r| r as u64)
}

/// Adds the counts of a table to a sum on the same axes.
fn add(sum: &mut Table, table: &Table, index: usize) -> Result<(), Error> {
    let (expected, found) = (randomisations(sum), randomisations(table));
    if expected != found {
        return Err(differs("randomisation", index, expected, found));
    }
    if let (Some(counts), Some(more)) = (&mut sum.counts, &table.counts) {
        Zip::from(counts).and(more).for_each(|n, more| *n += more);
    }
    if let (Some(fates), Some(more)) = (&mut sum.fate_counts, &table.fate_counts) {
        Zip::from(fates).and(more).for_each(|n, more| *n += more);
    }
    if let (Some(found), Some(more)) = (&mut sum.deviations, &table.deviations) {
        *found = more_deviations(found, more);
    }
    Ok(())
}

/// Adds the rays by shift and deviation, direction by direction.
fn more_deviations(a: &Deviations, b: &Deviations) -> Deviations {
    let pairs = a.entries.iter().zip(&b.entries);
    Deviations {
        grid: a.grid,
        entries: pairs.map(|(a, b)| deviation::added(a, b)).collect(),
    }
}

/// Puts whole tables of seeds that follow one another side by side along the randomisation axis.
fn side_by_side(tables: &[Table], ranges: &[Table]) -> Result<Table, Error> {
    let mut expected = ranges[0].provenance.seed;
    for table in ranges {
        let seed = table.provenance.seed;
        if let Some(shards) = &table.provenance.shards {
            let (missing, of) = (shards.missing_text(), shards.of);
            return Err(Error::Merge {
                fault: format!("shards {missing} of {of} of seed {seed} are missing"),
                remedy: "merge all shards of this seed before you add another seed".into(),
            });
        }
        if seed != expected {
            let index = tables
                .iter()
                .position(|t| t.provenance.seed == seed)
                .unwrap_or(0);
            return Err(Error::Merge {
                fault: format!(
                    "table {index} has seed {seed}, but the next seed after those of the other \
                    tables is {expected}"
                ),
                remedy: format!("bake it with --seed {expected}"),
            });
        }
        expected = expected.wrapping_add(randomisations(table) as u64);
    }
    let counts: Vec<_> = ranges
        .iter()
        .filter_map(|t| t.counts.as_ref())
        .map(|c| c.view())
        .collect();
    let fates: Vec<_> = ranges
        .iter()
        .filter_map(|t| t.fate_counts.as_ref())
        .map(|c| c.view())
        .collect();
    let (Ok(counts), Ok(fates)) = (concatenate(Axis(2), &counts), concatenate(Axis(2), &fates))
    else {
        unreachable!("equal axes give equal shapes but for the randomisations");
    };
    let deviations = ranges.iter().filter_map(|table| table.deviations.clone());
    Ok(Table {
        deviations: deviations.reduce(|sum, more| more_deviations(&sum, &more)),
        ..Table::from_counts(
            ranges[0].axes.clone(),
            // `concatenate` leaves a layout of its own.
            counts.as_standard_layout().into_owned(),
            fates.as_standard_layout().into_owned(),
            ranges[0].provenance.clone(),
        )
    })
}

/// Returns the number of randomisations of a table.
fn randomisations(table: &Table) -> usize {
    table.counts.as_ref().map_or(0, |counts| counts.shape()[2])
}

/// Returns the table that follows from the counts, after the counts have changed.
fn rebuilt(table: Table) -> Table {
    match (table.counts, table.fate_counts) {
        (Some(counts), Some(fates)) => Table {
            deviations: table.deviations,
            ..Table::from_counts(table.axes, counts, fates, table.provenance)
        },
        (counts, fate_counts) => Table {
            counts,
            fate_counts,
            ..table
        },
    }
}
