//! Samples of the ray shift of one direction of a table.

use std::collections::BTreeMap;

use tables::deviation::Exits;
use tables::{Direction, Path};

use edges::numerics::Quantile;

/// Departure of a ray: its shift, and its direction off the exact way back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Departure {
    /// Ray shift (u, v), edge lengths, before foreshortening.
    pub shift: [f64; 2],
    /// Tangents of the ray's angles off the exact way back, (tangential, sagittal).
    pub deviation: [f64; 2],
}

/// Map from points of the unit square to departures.
///
/// An exact direction is sampled from its polygons. Otherwise samples come from the bins of the
/// histogram, each an even box. This blurs by one bin, as `Direction::otf_along` does.
#[derive(Debug, Clone)]
pub struct ShiftSampler(Support);

#[derive(Debug, Clone)]
enum Support {
    /// Triangles of shifts, chosen by their power.
    Triangles {
        share: Quantile,
        triangles: Vec<([[f64; 2]; 3], [f64; 2])>,
    },
    /// Cells of shifts, each with one deviation, and the bins of each cell.
    Exits {
        share: Quantile,
        exits: Vec<([usize; 2], [f64; 2])>,
        bins: BTreeMap<[usize; 2], Quantile>,
        /// Bins along a side of a cell, then the width of a bin and the range of the histogram,
        /// both in edge lengths.
        pool: usize,
        width: f64,
        range: f64,
    },
    /// Rows of the histogram, and the columns of each row.
    Bins {
        rows: Quantile,
        columns: Vec<Option<Quantile>>,
    },
}

impl ShiftSampler {
    /// Makes the sampler of a direction. Returns `None` if no light is retroreflected.
    pub fn new(direction: &Direction) -> Option<ShiftSampler> {
        let support = match (&direction.paths, &direction.exits) {
            (Some(paths), _) => triangles(paths)?,
            (None, Some(found)) => exits(direction, found)?,
            (None, None) => bins(direction)?,
        };
        Some(ShiftSampler(support))
    }

    /// Returns whether any light leaves off the exact way back.
    pub fn deviates(&self) -> bool {
        match &self.0 {
            Support::Triangles { triangles, .. } => {
                triangles.iter().any(|(_, off)| *off != [0.0; 2])
            }
            Support::Exits { .. } => true,
            Support::Bins { .. } => false,
        }
    }

    /// Returns the departure for a point of the unit square.
    pub fn at(&self, [u, v]: [f64; 2]) -> Departure {
        match &self.0 {
            Support::Triangles { share, triangles } => {
                let (place, index) = share.at(u);
                let ([a, b, c], deviation) = triangles[index];
                // The root of the share gives the way from the first corner, and v the way across.
                let away = (place - index as f64).sqrt();
                let shift =
                    std::array::from_fn(|k| a[k] + away * (b[k] - a[k] + v * (c[k] - b[k])));
                Departure { shift, deviation }
            }
            Support::Exits {
                share,
                exits,
                bins,
                pool,
                width,
                range,
            } => {
                let (place, index) = share.at(u);
                let (cell, deviation) = exits[index];
                // Both coordinates have chosen a bin. Their remainders are even within the bin.
                let (row, bin) = bins[&cell].at(v);
                let part = [place - index as f64, row - bin as f64];
                let first = [cell[1] * pool + bin % pool, cell[0] * pool + bin / pool];
                let shift = [0, 1].map(|k| (first[k] as f64 + part[k]) * width - range);
                Departure { shift, deviation }
            }
            Support::Bins { rows, columns } => {
                let (shift_v, row) = rows.at(v);
                // Only rows with mass are drawn.
                let shift_u = columns[row].as_ref().map_or(0.0, |columns| columns.at(u).0);
                Departure {
                    shift: [shift_u, shift_v],
                    deviation: [0.0; 2],
                }
            }
        }
    }
}

/// Cuts the images of all paths' polygons into fans of triangles. The polygons are convex, because
/// a beam is cut by planes.
fn triangles(paths: &[Path]) -> Option<Support> {
    let (mut masses, mut triangles) = (Vec::new(), Vec::new());
    for path in paths {
        let Some((&a, rest)) = path.polygon.split_first() else {
            continue;
        };
        for pair in rest.windows(2) {
            let [b, c] = [pair[0], pair[1]];
            let twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            masses.push(path.weight * twice.max(0.0));
            triangles.push(([a, b, c].map(|entry| path.shift(entry)), path.deviation));
        }
    }
    Some(Support::Triangles {
        share: Quantile::new(0.0, 1.0, &masses)?,
        triangles,
    })
}

fn exits(direction: &Direction, found: &Exits) -> Option<Support> {
    let probability = &direction.probability;
    let pool = probability.ncols() / found.grid.cells;
    let (mut masses, mut exits, mut bins) = (Vec::new(), Vec::new(), BTreeMap::new());
    for &(place, mass) in &found.probability {
        let (cell, bin) = found.grid.at(place);
        masses.push(mass);
        exits.push((cell, found.grid.deviation(bin)));
        if let std::collections::btree_map::Entry::Vacant(vacant) = bins.entry(cell) {
            let at = |k: usize| (cell[0] * pool + k / pool, cell[1] * pool + k % pool);
            let inside: Vec<f64> = (0..pool * pool).map(|k| probability[at(k)]).collect();
            vacant.insert(Quantile::new(0.0, 1.0, &inside)?);
        }
    }
    Some(Support::Exits {
        share: Quantile::new(0.0, 1.0, &masses)?,
        exits,
        bins,
        pool,
        width: 2.0 * direction.range / probability.ncols() as f64,
        range: direction.range,
    })
}

fn bins(direction: &Direction) -> Option<Support> {
    let probability = &direction.probability;
    let first = -direction.range;
    let width = 2.0 * direction.range / probability.ncols() as f64;
    let rows: Vec<f64> = probability.rows().into_iter().map(|r| r.sum()).collect();
    Some(Support::Bins {
        rows: Quantile::new(first, width, &rows)?,
        columns: probability
            .rows()
            .into_iter()
            .map(|row| Quantile::new(first, width, &row.to_vec()))
            .collect(),
    })
}
