//! Samples of the ray shift of one direction of a table.

use tables::{Direction, Path};

use super::Quantile;

/// Maps points of the unit square to ray shifts (u, v), edge lengths, before foreshortening.
///
/// From the polygons of an exact direction, else from the histogram's bins, each an even box, which blurs by one bin (as
/// `Direction::otf_along` does).
#[derive(Debug, Clone)]
pub struct ShiftSampler(Support);

#[derive(Debug, Clone)]
enum Support {
    /// Triangles of shifts, chosen by their power.
    Triangles {
        share: Quantile,
        triangles: Vec<[[f64; 2]; 3]>,
    },
    /// Rows of the histogram, and the columns of each.
    Bins {
        rows: Quantile,
        columns: Vec<Option<Quantile>>,
    },
}

impl ShiftSampler {
    /// The sampler of a direction; `None` where nothing is retroreflected.
    pub fn new(direction: &Direction) -> Option<ShiftSampler> {
        let support = match &direction.paths {
            Some(paths) => triangles(paths)?,
            None => bins(direction)?,
        };
        Some(ShiftSampler(support))
    }

    /// The shift of a point of the unit square.
    pub fn at(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        match &self.0 {
            Support::Triangles { share, triangles } => {
                let (place, index) = share.at(u);
                let [a, b, c] = triangles[index];
                // Away from the first corner by the root of the share, and across by v.
                let away = (place - index as f64).sqrt();
                std::array::from_fn(|k| a[k] + away * (b[k] - a[k] + v * (c[k] - b[k])))
            }
            Support::Bins { rows, columns } => {
                let (shift_v, row) = rows.at(v);
                // A row that is drawn has mass.
                let shift_u = columns[row].as_ref().map_or(0.0, |columns| columns.at(u).0);
                [shift_u, shift_v]
            }
        }
    }
}

/// The images of all paths' polygons as fans of triangles. Polygons are convex: a beam is cut by planes.
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
            triangles.push([a, b, c].map(|entry| path.shift(entry)));
        }
    }
    Some(Support::Triangles {
        share: Quantile::new(0.0, 1.0, &masses)?,
        triangles,
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
