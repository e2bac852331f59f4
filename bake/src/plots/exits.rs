//! Pictures of the directions in which light leaves cells that are not ideal.

use crate::plots::figure::{Labels, PlotError, figure};
use kuva::plot::Heatmap;
use kuva::render::plots::Plot;
use std::path::Path;
use tables::Table;

/// Number of cells of a panel along each axis.
///
/// It is odd, so that straight back is the middle of a cell.
const CELLS: usize = 41;

/// Returns a picture of the exit directions of `table` as the bytes of a PNG or SVG file.
///
/// The picture has one panel per direction. The panel shows the deviation from straight back, mrad:
/// in the plane of incidence to the right, and along v upward. The colour is the probability per
/// launched ray.
///
/// # Errors
/// Returns [`PlotError::Straight`] if all light of the table goes straight back,
/// [`PlotError::Format`] if the extension of `file` names no format, and [`PlotError::Draw`] if the
/// plotting crate fails.
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
        title: "deviation from straight back, probability per launched ray",
        axes: [
            "across, in the plane of incidence, mrad",
            "along v = n x u, mrad",
        ],
    };
    figure(table, file, &labels, &map)
}

/// Deviation (across, along v) as tangents, and the probability per launched ray.
type Spot = ([f64; 2], f64);

/// Returns the exit directions of direction number `direction`, with their probabilities.
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
