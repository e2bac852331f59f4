//! Pictures of the histograms of shifts.

use crate::plots::figure::{Labels, PlotError, figure};
use kuva::plot::Heatmap;
use kuva::render::plots::Plot;
use std::path::Path;
use tables::Table;

/// Largest number of cells of a panel along each axis.
///
/// More bins than that are pooled. Otherwise an SVG of ten panels has 6 MB.
const MOST_CELLS: usize = 32;

/// Returns a picture of the histograms of `table` as the bytes of a PNG or SVG file.
///
/// The picture has one panel per direction, with the retroreflected fraction above it: u to the
/// right, v upward. The colour is the density per launched ray and square edge length. The
/// extension of `file` names the format.
///
/// # Errors
/// Returns [`PlotError::Format`] if the extension of `file` names no format, and
/// [`PlotError::Draw`] if the plotting crate fails.
pub(crate) fn histograms(table: &Table, file: &Path) -> Result<Vec<u8>, PlotError> {
    let labels = Labels {
        title: "ray shift p' - p, probability per launched ray and square edge length",
        axes: [
            "u (direction of travel), edge lengths",
            "v = n x u, edge lengths",
        ],
    };
    figure(table, file, &labels, &|at| histogram(table, at))
}

/// Returns the density of the shifts of a direction as a heat map.
fn histogram(table: &Table, (i, a): (usize, usize)) -> Plot {
    let axes = &table.axes;
    let pool = axes.bins.div_ceil(MOST_CELLS);
    let cells = axes.bins.div_ceil(pool);
    let width = axes.bin_width() * pool as f64;
    let mut density = vec![vec![0.0; cells]; cells];
    for ((v, u), probability) in table.probability(i, a).indexed_iter() {
        // Row 0 of a heat map with a range is drawn at its lower end.
        density[v / pool][u / pool] += probability / (width * width);
    }
    let end = cells as f64 * width - axes.range;
    let map = Heatmap::new()
        .with_data(density)
        .with_x_range(-axes.range, end)
        .with_y_range(-axes.range, end)
        .with_cell_size(1.0)
        .with_legend("per ray");
    Plot::Heatmap(map)
}
