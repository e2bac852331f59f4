//! Tables of some directions, put on the axes of all directions.

use ndarray::{Array2, Array3, Array4, Array5, s};

use crate::error::Error;
use crate::merge::merge::{differs, gap, overlap};
use crate::table::axes::Axes;
use crate::table::deviation::Deviations;
use crate::table::exact::Exact;
use crate::table::provenance::Provenance;
use crate::table::table::Table;

/// Returns the axes that hold every incidence and every azimuth of the tables, which share bins and
/// range.
pub(crate) fn union(tables: &[Table]) -> Axes {
    let merged = |angles: &dyn Fn(&Axes) -> &[f64]| {
        let mut all: Vec<f64> = tables
            .iter()
            .flat_map(|table| angles(&table.axes))
            .copied()
            .collect();
        all.sort_by(f64::total_cmp);
        all.dedup_by(|a, b| same(*a, *b));
        all
    };
    Axes {
        incidence_deg: merged(&|axes| &axes.incidence_deg),
        azimuth_deg: merged(&|axes| &axes.azimuth_deg),
        ..tables[0].axes.clone()
    }
}

/// Returns whether two angles are equal; the NaN azimuth of a mean equals itself.
fn same(a: f64, b: f64) -> bool {
    a == b || (a.is_nan() && b.is_nan())
}

/// Returns the indices at which `table` holds this direction of `axes`, or `None` if it does not.
pub(crate) fn place(table: &Table, axes: &Axes, (i, j): (usize, usize)) -> Option<(usize, usize)> {
    let find = |own: &[f64], angle: f64| own.iter().position(|&x| same(x, angle));
    Some((
        find(&table.axes.incidence_deg, axes.incidence_deg[i])?,
        find(&table.axes.azimuth_deg, axes.azimuth_deg[j])?,
    ))
}

/// Returns the directions of `axes`, row-major.
fn all(axes: &Axes) -> impl Iterator<Item = (usize, usize)> + use<> {
    let (incidences, azimuths) = axes.shape();
    (0..incidences).flat_map(move |i| (0..azimuths).map(move |j| (i, j)))
}

/// Returns the table on the axes `axes`, without rays in the directions that it does not hold.
pub(crate) fn spread(table: &Table, axes: &Axes) -> Table {
    let (Some(counts), Some(fates), false) =
        (&table.counts, &table.fate_counts, table.axes == *axes)
    else {
        return table.clone();
    };
    let ((n, m), r, b) = (axes.shape(), counts.shape()[2], axes.bins);
    let mut wide = (
        Array5::zeros((n, m, r, b, b)),
        Array4::zeros((n, m, r, fates.shape()[3])),
    );
    let grid = table.deviations.as_ref().map(|found| found.grid);
    let mut deviations = grid.map(|grid| Deviations::new(grid, n * m));
    for (i, j) in all(axes) {
        if let Some((own_i, own_j)) = place(table, axes, (i, j)) {
            let from = counts.slice(s![own_i, own_j, .., .., ..]);
            wide.0.slice_mut(s![i, j, .., .., ..]).assign(&from);
            let from = fates.slice(s![own_i, own_j, .., ..]);
            wide.1.slice_mut(s![i, j, .., ..]).assign(&from);
            if let (Some(wide), Some(own)) = (&mut deviations, &table.deviations) {
                let place = own_i * table.axes.azimuth_deg.len() + own_j;
                wide.entries[i * m + j].clone_from(&own.entries[place]);
            }
        }
    }
    Table {
        deviations,
        ..Table::from_counts(axes.clone(), wide.0, wide.1, table.provenance.clone())
    }
}

/// Joins exact tables of different directions.
///
/// # Errors
/// Returns a [`Error`] if entrance areas differ, or if a direction is held by no table or by
/// two.
pub(crate) fn join(tables: &[Table], axes: Axes) -> Result<Table, Error> {
    let ((n, m), b) = (axes.shape(), axes.bins);
    let mut joined = Table {
        histogram: Array4::zeros((n, m, b, b)),
        counts: None,
        retroreflected: Array2::zeros((n, m)),
        standard_error: Array2::zeros((n, m)),
        fate: Array3::zeros((n, m, tables[0].fate.shape()[2])),
        fate_counts: None,
        rays: Array2::zeros((n, m)),
        exact: None,
        deviations: None,
        passage: None,
        errors_rad: [0.0; 3],
        provenance: Provenance {
            // Nobody has checked the interpolation in the gaps between the tables.
            direction_tolerance: None,
            ..tables[0].provenance.clone()
        },
        axes,
    };
    let mut paths = vec![Vec::new(); n * m];
    let area = |table: &Table| table.exact.as_ref().map(|exact| exact.entrance_area);
    for (index, table) in tables.iter().enumerate() {
        if area(table) != area(&tables[0]) {
            let [expected, found] = [&tables[0], table].map(|table| format!("{:?}", area(table)));
            return Err(differs("entrance_area", index, expected, found));
        }
    }
    for (i, j) in all(&joined.axes) {
        let mut holders = tables
            .iter()
            .enumerate()
            .filter_map(|(index, table)| Some((index, table, place(table, &joined.axes, (i, j))?)));
        let Some((first, table, (own_i, own_j))) = holders.next() else {
            let axes = &joined.axes;
            return Err(gap(axes.incidence_deg[i], axes.azimuth_deg[j], 0));
        };
        if let Some((second, ..)) = holders.next() {
            return Err(overlap(first, second, "the exact distribution", (i, j)));
        }
        let from = table.histogram.slice(s![own_i, own_j, .., ..]);
        joined.histogram.slice_mut(s![i, j, .., ..]).assign(&from);
        joined.retroreflected[[i, j]] = table.retroreflected[[own_i, own_j]];
        let from = table.fate.slice(s![own_i, own_j, ..]);
        joined.fate.slice_mut(s![i, j, ..]).assign(&from);
        if let Some(exact) = &table.exact {
            paths[i * m + j] = exact.paths[own_i * table.axes.azimuth_deg.len() + own_j].clone();
        }
    }
    joined.exact = area(&tables[0]).map(|entrance_area| Exact {
        entrance_area,
        paths,
    });
    Ok(joined)
}
