//! Pictures of the histograms of shifts.

use crate::plots::figure::{Labels, PlotError, figure};
use kuva::plot::Heatmap;
use kuva::render::plots::Plot;
use std::path::Path;
use tables::Table;

/// Cells of a panel along each axis at most: bins are pooled above that, or an SVG of ten panels
/// has 6 MB.
const MOST_CELLS: usize = 32;

/// The histograms of `table` as the bytes of a PNG or SVG file, by the extension of `file`: one
/// panel per direction with its retroreflected fraction, u to the right, v upward, density per
/// launched ray and square edge length.
///
/// # Errors
/// [`PlotError`].
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

/// The density of the shifts of a direction.
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
