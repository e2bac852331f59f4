//! Rules that every table obeys, in memory and on disk.
//!
//! Tolerance: a fraction is rounded to 2^-53 of itself. A sum of n fractions that should be 1 is
//! therefore off by at most about n 2^-53: 2e-12 for 128 x 128 bins, 1e-10 for 1024 x 1024. `SUM`
//! allows 1e-9. The areas of polygons whose coordinates are some edge lengths stay within it too,
//! with room to spare.

mod polygons;

use ndarray::{Array2, Array4, Array5, Axis, s};

use crate::options::Method;
use crate::table::axes::Axes;
use crate::table::check::polygons::polygons;
use crate::table::deviation::{Deviations, Entry, Grid};
use crate::table::fate::Fate;
use crate::table::provenance::Provenance;
use crate::table::symmetry::MOST_ROTATIONS;
use crate::table::table::Table;

/// Allowed rounding of sums that should be 1 and of areas that should be eta.
pub(crate) const SUM: f64 = 1e-9;

/// Greatest coordinate, shift and tangent in the polygons of a table, edge lengths.
///
/// A sheet has some, and the range of a histogram ends there too.
const FARTHEST: f64 = 1e6;

/// Greatest number of directions of a table: three times all whole degrees of the hemisphere, 90
/// incidences by 360 azimuths.
pub const MOST_DIRECTIONS: usize = 100_000;

/// Greatest number of rays of a direction: f64 does not hold greater numbers exactly.
pub(crate) const MOST_RAYS: u64 = 1 << 53;

/// Rule that a table breaks, with the place. Directions are (index along incidence, index along
/// azimuth).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct Invalid(String);

/// Returns the rule that the table breaks.
macro_rules! broken {
    ($($words:tt)*) => {
        return Err(Invalid(format!($($words)*)))
    };
}

use broken;

/// Checks all rules of a table.
///
/// `Ok` says that the table can be written, read and used without further checks.
///
/// # Errors
/// Returns the first rule that the table breaks, with the place.
pub fn check(table: &Table) -> Result<(), Invalid> {
    axes(&table.axes)?;
    shapes(table)?;
    values(table)?;
    if let (Some(bins), Some(fates)) = (&table.counts, &table.fate_counts) {
        counts(bins, fates, &table.rays)?;
    }
    sums(table)?;
    if let Some(exact) = &table.exact {
        polygons(table, exact)?;
    }
    if let Some(found) = &table.deviations {
        deviations(table, found)?;
    }
    method(table)
}

/// Checks the axes alone, before anything of their size is allocated.
pub(crate) fn axes(axes: &Axes) -> Result<(), Invalid> {
    axis(
        "incidence_deg",
        &axes.incidence_deg,
        "0 <= angle < 90",
        |x| (0.0..90.0).contains(&x),
    )?;
    if !axes.is_mean() {
        axis(
            "azimuth_deg",
            &axes.azimuth_deg,
            "-360 <= angle <= 360 (NaN alone for a mean)",
            |x| x.abs() <= 360.0,
        )?;
    }
    let (incidences, azimuths) = axes.shape();
    let directions = incidences.saturating_mul(azimuths);
    most(MOST_DIRECTIONS, directions, || "the directions".into())?;
    if axes.bins == 0 {
        broken!("shift_u is empty");
    }
    axis("shift_range", &[axes.range], "0 < range < 1e6", |x| {
        x > 0.0 && x < 1e6
    })
}

/// Checks that there are at most `limit` of something, which `what` names.
fn most(limit: usize, found: usize, what: impl Fn() -> String) -> Result<(), Invalid> {
    if found > limit {
        broken!("{} are {found}, above the limit of {limit}", what());
    }
    Ok(())
}

/// Checks that an axis has values, that all are allowed, and that they ascend.
fn axis(
    axis: &'static str,
    values: &[f64],
    allowed: &'static str,
    within: impl Fn(f64) -> bool,
) -> Result<(), Invalid> {
    if values.is_empty() {
        broken!("{axis} is empty");
    }
    if let Some((index, value)) = values.iter().enumerate().find(|&(_, &x)| !within(x)) {
        broken!("{axis} is {value:?} at index {index}, outside of {allowed}");
    }
    if let Some(index) = values.windows(2).position(|pair| pair[0] >= pair[1]) {
        broken!("{axis} does not ascend at index {}", index + 1);
    }
    Ok(())
}

/// Checks the shape of an array.
fn shape(array: &str, found: &[usize], expected: &[usize]) -> Result<(), Invalid> {
    if found != expected {
        broken!("{array} has shape {found:?}, the axes ask for {expected:?}");
    }
    Ok(())
}

/// Checks that all arrays have the shapes that follow from the axes.
fn shapes(table: &Table) -> Result<(), Invalid> {
    let (i, j) = table.axes.shape();
    let columns = *table.fate.shape().last().unwrap_or(&0);
    let (b, f) = (table.axes.bins, table.provenance.fates(columns).len());
    shape("histogram", table.histogram.shape(), &[i, j, b, b])?;
    shape("retroreflected", table.retroreflected.shape(), &[i, j])?;
    shape("standard_error", table.standard_error.shape(), &[i, j])?;
    shape("fate", table.fate.shape(), &[i, j, f])?;
    shape("rays", table.rays.shape(), &[i, j])?;
    match (&table.counts, &table.fate_counts) {
        (Some(counts), Some(fate_counts)) => {
            let r = counts.shape()[2];
            if r == 0 {
                broken!("randomisation is empty");
            }
            shape("counts", counts.shape(), &[i, j, r, b, b])?;
            shape("fate_counts", fate_counts.shape(), &[i, j, r, f])
        }
        (None, None) => Ok(()),
        (Some(_), None) => broken!("counts is there without fate_counts"),
        (None, Some(_)) => broken!("fate_counts is there without counts"),
    }
}

/// Checks that all numbers lie in their ranges.
fn values(table: &Table) -> Result<(), Invalid> {
    // The rounding of a sum of fractions may lift it above 1.
    let fraction = |x: f64| (0.0..=1.0 + SUM).contains(&x);
    let error = |x: f64| (0.0..=1.0).contains(&x);
    within("histogram", table.histogram.iter(), "0 to 1", fraction)?;
    within(
        "retroreflected",
        table.retroreflected.iter(),
        "0 to 1",
        fraction,
    )?;
    within("fate", table.fate.iter(), "0 to 1", fraction)?;
    within(
        "standard_error",
        table.standard_error.iter(),
        "0 to 1",
        error,
    )?;
    if table.counts.is_none() {
        // The content hash covers neither of the two.
        let none = |x: f64| x == 0.0;
        let rays: Vec<f64> = table.rays.iter().map(|&n| n as f64).collect();
        within("rays", &rays, "0 where there are no counts", none)?;
        within(
            "standard_error",
            table.standard_error.iter(),
            "0 where there are no counts",
            none,
        )?;
    }
    provenance(&table.provenance)
}

/// Checks that the numbers of the provenance lie in their ranges.
///
/// The ranges hold all that `bake` takes. What it has no range for is bounded too, because a reader
/// computes with it.
fn provenance(p: &Provenance) -> Result<(), Invalid> {
    let share = |x: f64| x > 0.0 && x <= 1.0;
    within("edge_length", [&p.edge_length], "1e-12 to 1e12", |x| {
        (1e-12..=1e12).contains(&x)
    })?;
    within("refractive_index", [&p.refractive_index], "1 to 10", |x| {
        (1.0..=10.0).contains(&x)
    })?;
    within("azimuth_zero", &p.azimuth_zero, "-1e12 to 1e12", |x| {
        x.abs() <= 1e12
    })?;
    let length: f64 = p.azimuth_zero.iter().map(|x| x * x).sum();
    within("length of azimuth_zero", [&length], "above 0", |x| x > 0.0)?;
    within("reflectance", [&p.reflectance], "above 0 to 1", share)?;
    within(
        "angular_tolerance_deg",
        [&p.angular_tolerance_deg],
        "above 0 to 90",
        |x| x > 0.0 && x <= 90.0,
    )?;
    within("tolerance", [&p.tolerance], "0 to 2", |x| {
        (0.0..=2.0).contains(&x)
    })?;
    let rotations = f64::from(p.symmetry.rotations);
    within(
        "symmetry_rotations",
        [&rotations],
        "whole numbers from 1 to 360",
        |n| (1.0..=f64::from(MOST_ROTATIONS)).contains(&n),
    )?;
    within(
        "symmetry_mirror_deg",
        &p.symmetry.mirror_deg,
        "from 0 to below 360",
        |x| (0.0..360.0).contains(&x),
    )?;
    within("wavelength_nm", &p.wavelength_nm, "above 0 to 1e6", |x| {
        x > 0.0 && x <= 1e6
    })?;
    let metal: &[f64] = p.metal_index.as_ref().map_or(&[], |index| index);
    within("metal_index", metal, "0 to 1000", |x| {
        (0.0..=1e3).contains(&x)
    })?;
    within(
        "direction_tolerance",
        &p.direction_tolerance,
        "above 0 to 1",
        share,
    )?;
    let Some([a, b]) = p.lattice else {
        return Ok(());
    };
    within("lattice", [a, b].as_flattened(), "-1e6 to 1e6", |x| {
        x.abs() <= FARTHEST
    })?;
    let area = a[0] * b[1] - a[1] * b[0];
    within("area of lattice", [&area], "above 0", |x| x > 0.0)
}

/// Checks that the table holds what its method makes: rays are counted, and an exact table has
/// polygons and no counts.
///
/// A method or a sampler of a later version passes.
fn method(table: &Table) -> Result<(), Invalid> {
    let from = &table.provenance;
    let holds = [table.counts.is_some(), table.exact.is_some()];
    let fits = match from.method.known() {
        None => true,
        Some(Method::Rays) => holds == [true, false] && from.sampler.is_some(),
        Some(Method::Exact) => holds == [false, true] && from.sampler.is_none(),
        Some(Method::Auto) => false,
    };
    let [counts, polygons] = holds.map(|there| if there { "has" } else { "lacks" });
    if !fits {
        broken!(
            "method is \"{}\" and sampler is \"{}\", but the table {counts} counts and {polygons} \
            polygons",
            from.method,
            from.sampler_text()
        );
    }
    Ok(())
}

/// Checks that `allow` holds for all values; `allowed` names the range in the error.
fn within<'a>(
    array: &'static str,
    values: impl IntoIterator<Item = &'a f64>,
    allowed: &'static str,
    allow: impl Fn(f64) -> bool,
) -> Result<(), Invalid> {
    if let Some((index, value)) = values.into_iter().enumerate().find(|&(_, &x)| !allow(x)) {
        broken!("{array} is {value:?} at flat index {index}, outside of {allowed}");
    }
    Ok(())
}

/// Checks the counts against fates and rays.
///
/// Sums are in u128, because the counts of a hostile file overflow u64.
pub(crate) fn counts(
    counts: &Array5<u64>,
    fate_counts: &Array4<u64>,
    launched: &Array2<u64>,
) -> Result<(), Invalid> {
    let (incidences, azimuths) = launched.dim();
    for direction in (0..incidences).flat_map(|i| (0..azimuths).map(move |j| (i, j))) {
        let (i, j) = direction;
        let mut rays = 0_u128;
        for randomisation in 0..counts.shape()[2] {
            let bins = counts
                .index_axis(Axis(0), i)
                .index_axis_move(Axis(0), j)
                .index_axis_move(Axis(0), randomisation);
            let sum: u128 = bins.iter().map(|&n| u128::from(n)).sum();
            let fates = fate_counts[[i, j, randomisation, Fate::Retroreflected as usize]];
            if sum != u128::from(fates) {
                broken!(
                    "counts sum to {sum} at direction {direction:?}, randomisation \
                    {randomisation}, fate_counts says {fates} retroreflected"
                );
            }
            rays += (0..fate_counts.shape()[3])
                .map(|k| u128::from(fate_counts[[i, j, randomisation, k]]))
                .sum::<u128>();
        }
        if rays > u128::from(MOST_RAYS) {
            broken!("fate_counts sums to {rays} at direction {direction:?}, above 2^53");
        }
        if rays != u128::from(launched[[i, j]]) {
            let launched = launched[[i, j]];
            broken!("rays is {launched} at direction {direction:?}, fate_counts sums to {rays}");
        }
    }
    Ok(())
}

/// Checks that fates and histograms sum to 1 and that eta follows from the fates.
fn sums(table: &Table) -> Result<(), Invalid> {
    let (incidences, azimuths) = table.axes.shape();
    let near = |a: f64, b: f64| (a - b).abs() <= SUM;
    for direction in (0..incidences).flat_map(|i| (0..azimuths).map(move |j| (i, j))) {
        let (i, j) = direction;
        // A shard launches no rays in the directions of the other shards.
        let idle = table.counts.is_some() && table.rays[[i, j]] == 0;
        let fate = table
            .fate
            .index_axis(Axis(0), i)
            .index_axis_move(Axis(0), j);
        let sum = fate.sum();
        let unlaunched = idle && sum == 0.0;
        if !unlaunched && !near(sum, 1.0) {
            broken!("fate sums to {sum} at direction {direction:?}, expected 1");
        }
        let eta = table.retroreflected[[i, j]];
        let fates = fate[Fate::Retroreflected as usize] + fate[Fate::OutOfRange as usize];
        if !near(eta, fates) {
            broken!(
                "retroreflected is {eta} at direction {direction:?}, fate retroreflected + \
                out_of_range is {fates}"
            );
        }
        let sum = table
            .histogram
            .index_axis(Axis(0), i)
            .index_axis_move(Axis(0), j)
            .sum();
        if sum != 0.0 && !near(sum, 1.0) {
            broken!(
                "histogram sums to {sum} at direction {direction:?}, expected 1, or 0 where \
                nothing returns"
            );
        }
        if eta == 0.0 && sum != 0.0 {
            broken!("histogram is not empty at direction {direction:?} where retroreflected is 0");
        }
    }
    Ok(())
}

/// Checks the rays by deviation: their grid, their order, and their sums against `counts`.
fn deviations(table: &Table, found: &Deviations) -> Result<(), Invalid> {
    let (incidences, azimuths) = table.axes.shape();
    let Some(counts) = &table.counts else {
        broken!("deviation is there without counts");
    };
    let directions = [incidences * azimuths];
    shape("deviation entries", &[found.entries.len()], &directions)?;
    let Grid { cells, bins, range } = found.grid;
    let of_bins = table.axes.bins;
    within(
        "deviation cells",
        [&(cells as f64)],
        "the divisors of the bins",
        |_| (1..=Grid::MOST).contains(&cells) && of_bins.is_multiple_of(cells),
    )?;
    within("deviation bins", [&(bins as f64)], "1 to 4096", |_| {
        (1..=Grid::MOST).contains(&bins)
    })?;
    within("deviation range", [&range], "above 0 to 1e6", |x| {
        x > 0.0 && x <= 1e6
    })?;
    let (pool, places) = (of_bins / cells, found.grid.places());
    for (direction, entries) in found.entries.iter().enumerate() {
        let mut by_cell = Array2::<u128>::zeros((cells, cells));
        let mut lowest = 0;
        for (entry, &Entry { place, rays }) in entries.iter().enumerate() {
            if place < lowest || place >= places || rays == 0 {
                broken!(
                    "entry {entry} of the deviations of direction {direction} has the place \
                    {place} and {rays} rays; places ascend below {places}, and rays are at least 1"
                );
            }
            lowest = place + 1;
            by_cell[found.grid.at(place).0] += u128::from(rays);
        }
        let (i, j) = (direction / azimuths, direction % azimuths);
        let mut counted = Array2::<u128>::zeros((cells, cells));
        for ((_, v, u), &rays) in counts.slice(s![i, j, .., .., ..]).indexed_iter() {
            counted[[v / pool, u / pool]] += u128::from(rays);
        }
        let differ = by_cell
            .indexed_iter()
            .find(|&(at, rays)| counted[at] != *rays);
        if let Some((cell, deviations)) = differ {
            broken!(
                "the deviations of direction {direction} have {deviations} rays in the cell (v, \
                u) = {cell:?}, counts has {}",
                counted[cell]
            );
        }
    }
    Ok(())
}
