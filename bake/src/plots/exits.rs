//! Pictures of where the light goes: the spots of cells that are not ideal.

use crate::plots::figure::{Labels, PlotError, figure};
use kuva::plot::Heatmap;
use kuva::render::plots::Plot;
use std::path::Path;
use tables::Table;

/// Cells of a panel along each axis; odd, so that straight back is in the middle of one.
const CELLS: usize = 41;

/// The exit directions of `table` as the bytes of a PNG or SVG file: one panel per direction, mrad
/// from straight back, across it in the plane of incidence to the right and along v upward,
/// probability per launched ray.
///
/// # Errors
/// [`PlotError`], as where the table has none.
pub(crate) fn exits(table: &Table, file: &Path) -> Result<Vec<u8>, PlotError> {
    let (_, azimuths) = table.axes.shape();
    let count = table.retroreflected.len();
    let spots: Vec<Vec<Spot>> = (0..count).map(|k| spots(table, k)).collect();
    let all = || spots.iter().flatten();
    let furthest = all()
        .flat_map(|spot| spot.0)
        .map(f64::abs)
        .fold(0.0, f64::max);
    if furthest == 0.0 {
        return Err(PlotError::Straight);
    }
    let half = 1.1e3 * furthest;
    let map = |(i, a): (usize, usize)| {
        let mut share = vec![vec![0.0; CELLS]; CELLS];
        let cell = |tangent: f64| {
            let part = (1e3 * tangent / half + 1.0) / 2.0;
            ((part * CELLS as f64) as usize).min(CELLS - 1)
        };
        for ([across, along], power) in &spots[i * azimuths + a] {
            share[cell(*along)][cell(*across)] += power;
        }
        let map = Heatmap::new()
            .with_data(share)
            .with_x_range(-half, half)
            .with_y_range(-half, half)
            .with_cell_size(1.0)
            .with_legend("per ray");
        Plot::Heatmap(map)
    };
    let labels = Labels {
        title: "light from straight back, probability per launched ray",
        axes: [
            "across, in the plane of incidence, mrad",
            "along v = n x u, mrad",
        ],
    };
    figure(table, file, &labels, &map)
}

/// Tangents (across, along v), and the probability per launched ray.
type Spot = ([f64; 2], f64);

fn spots(table: &Table, direction: usize) -> Vec<Spot> {
    if let Some(found) = &table.deviations {
        let azimuths = table.axes.azimuth_deg.len();
        let launched = table.rays[[direction / azimuths, direction % azimuths]].max(1) as f64;
        let spot = |entry: &tables::deviation::Entry| {
            let (_, bin) = found.grid.at(entry.place);
            (found.grid.deviation(bin), entry.rays as f64 / launched)
        };
        return found.entries[direction].iter().map(spot).collect();
    }
    let exact = table.exact.iter();
    let paths = exact.flat_map(|exact| {
        let paths = exact.paths.get(direction).into_iter().flatten();
        paths.map(|path| {
            let power = path.weight * path.area() / exact.entrance_area;
            (path.deviation, power)
        })
    });
    paths.collect()
}
