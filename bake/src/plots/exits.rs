//! Pictures of the directions in which light leaves cells that are not ideal.

use crate::plots::choice::Choice;
use crate::plots::heat::{Cells, Content, DirectionPanel, Picture};
use glam::DVec2;
use tables::Table;

/// Number of cells of a panel along each axis.
///
/// It is odd, so that straight back is the middle of a cell.
const CELLS: usize = 41;

/// Returns a picture of the exit directions of `table` as SVG; `None` if all light of the table
/// goes straight back.
///
/// The picture has one panel per direction. The panel shows the deviation from straight back, mrad:
/// in the plane of incidence to the right, and along v upward. The colour is the probability per
/// launched ray.
pub(crate) fn exits(table: &Table) -> Option<String> {
    let (_, azimuths) = table.axes.shape();
    let count = table.retroreflected.len();
    let spots: Vec<Vec<ExitSpot>> = (0..count).map(|k| spots(table, k)).collect();
    let all = || spots.iter().flatten();
    let furthest = all()
        .flat_map(|spot| spot.0)
        .map(f64::abs)
        .fold(0.0, f64::max);
    if furthest == 0.0 {
        return None;
    }
    let half = 1.1e3 * furthest;
    let cell = |tangent: f64| {
        let part = (1e3 * tangent / half + 1.0) / 2.0;
        ((part * CELLS as f64) as usize).min(CELLS - 1)
    };
    let panel = |&(i, a): &(usize, usize)| {
        let mut density = vec![vec![0.0; CELLS]; CELLS];
        for ([across, along], power) in &spots[i * azimuths + a] {
            density[cell(*along)][cell(*across)] += power;
        }
        let bins = Cells {
            density,
            corner: DVec2::splat(-half),
            size: DVec2::splat(2.0 * half / CELLS as f64),
        };
        DirectionPanel::new(table, (i, a), Content::Bins(bins), "")
    };
    let choice = Choice::of(table);
    let picture = Picture {
        title: format!("{}: deviation from straight back", table.provenance.design),
        axes: [
            "across, in the plane of incidence, mrad",
            "along v = n x u, mrad",
        ],
        bar: "share of launched light per cell",
        panels: choice.directions.iter().map(panel).collect(),
        columns: choice.columns,
        note: choice.note.unwrap_or_default(),
    };
    Some(picture.svg())
}

/// Deviation (across, along v) as tangents, and the probability per launched ray.
type ExitSpot = ([f64; 2], f64);

/// Returns the exit directions of direction number `direction`, with their probabilities.
fn spots(table: &Table, direction: usize) -> Vec<ExitSpot> {
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
