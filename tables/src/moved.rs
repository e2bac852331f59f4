//! Deviations as a part of the shift: what light is off by at one distance and one size of the cells.

use ndarray::Array2;

use crate::deviation::Exits;
use crate::lookup::Direction;
use crate::table::Path;

/// Bins along each axis at most: above, they are pooled. 32 MB.
const MOST_BINS: usize = 2048;

impl Direction {
    /// The direction whose light, straight back, is shifted by `per_tangent` (u, v; edge lengths) times its deviation besides its
    /// own shift.
    ///
    /// Polygons are moved. Bins are moved onto a wider histogram and shared out among the four around their place, which
    /// takes (2 pi kappa width)^2/12 from an OTF at kappa per edge length, half of what the bins themselves take.
    pub fn moved(self, per_tangent: [f64; 2]) -> Direction {
        let (probability, range) = match &self.exits {
            Some(exits) => bins(&self, exits, per_tangent),
            None => (self.probability, self.range),
        };
        let path = |path: Path| {
            let by = [0, 1].map(|k| per_tangent[k] * path.deviation[k]);
            Path {
                offset: [path.offset[0] + by[0], path.offset[1] + by[1]],
                deviation: [0.0; 2],
                ..path
            }
        };
        Direction {
            probability,
            range,
            exits: None,
            paths: self
                .paths
                .map(|paths| paths.into_iter().map(path).collect()),
            ..self
        }
    }
}

/// The histogram of shifts with deviations in it, and its range; `per_tangent` in edge lengths, (u, v).
fn bins(direction: &Direction, exits: &Exits, per_tangent: [f64; 2]) -> (Array2<f64>, f64) {
    let (bins, grid) = (&direction.probability, &exits.grid);
    let width = 2.0 * direction.range / bins.ncols() as f64;
    let centre = |k: usize| (k as f64 + 0.5) * width - direction.range;
    let moves = |place: u64| {
        let (cell, bin) = grid.at(place);
        let deviation = grid.deviation(bin);
        (cell, [0, 1].map(|k| per_tangent[k] * deviation[k]))
    };
    let held = bins.indexed_iter().filter(|(_, p)| **p > 0.0);
    let shift = held.map(|((v, u), _)| centre(v).abs().max(centre(u).abs()));
    let move_ = exits.probability.iter().map(|&(place, _)| moves(place).1);
    let move_ = move_.map(|by| by[0].abs().max(by[1].abs()));
    let reach = shift.fold(0.0, f64::max) + move_.fold(0.0, f64::max);
    // Room for the neighbours of the last bin.
    let half = (reach / width).ceil() as usize + 2;
    let pooled = (2 * half).div_ceil(MOST_BINS);
    let (step, count) = (width * pooled as f64, 2 * half.div_ceil(pooled));
    let range = 0.5 * step * count as f64;
    let mut moved = Array2::zeros((count, count));
    let pool = bins.ncols() / grid.cells;
    for &(place, share) in &exits.probability {
        let ([v, u], by) = moves(place);
        let inside = || {
            (v * pool..(v + 1) * pool)
                .flat_map(move |v| (u * pool..(u + 1) * pool).map(move |u| (v, u)))
        };
        let power: f64 = inside().map(|at| bins[at]).sum();
        for (v, u) in inside().filter(|&at| bins[at] > 0.0) {
            let mass = share * bins[(v, u)] / power;
            let at = [centre(u) + by[0], centre(v) + by[1]].map(|x| (x + range) / step - 0.5);
            let [(left, part_u), (low, part_v)] = at.map(|x| (x as usize, x.fract()));
            moved[[low, left]] += mass * (1.0 - part_v) * (1.0 - part_u);
            moved[[low, left + 1]] += mass * (1.0 - part_v) * part_u;
            moved[[low + 1, left]] += mass * part_v * (1.0 - part_u);
            moved[[low + 1, left + 1]] += mass * part_v * part_u;
        }
    }
    (moved, range)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deviation::Grid;

    /// Two bins with three spots between them: masses and their mean places by hand.
    #[test]
    fn bins_go_where_their_light_goes() {
        let grid = Grid {
            cells: 2,
            bins: 3,
            range: 3e-3,
        };
        let mut probability = Array2::zeros((4, 4));
        (probability[[0, 1]], probability[[3, 2]]) = (0.3, 0.2);
        let exits = Exits {
            grid,
            probability: vec![
                (grid.place([0, 0], [1, 1]), 0.1),
                (grid.place([0, 0], [1, 2]), 0.2),
                (grid.place([1, 1], [0, 1]), 0.2),
            ],
        };
        let direction = Direction {
            incidence_deg: 0.0,
            azimuth_deg: 0.0,
            eta: 0.5,
            probability,
            range: 2.0,
            standard_error: 0.0,
            interpolated: false,
            paths: None,
            exits: Some(exits),
        };
        // Bins of 2 mrad: the second spot is moved by 2.5 along u, the third by -5 along v.
        let moved = direction.moved([1250.0, 2500.0]);
        assert!(moved.exits.is_none() && moved.paths.is_none());
        let width = 2.0 * moved.range / moved.probability.ncols() as f64;
        assert!((width - 1.0).abs() < 1e-15);
        let centre = |k: usize| (k as f64 + 0.5) * width - moved.range;
        let moment = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            let cells = moved.probability.indexed_iter();
            cells.map(|((v, u), p)| p * of(centre(u), centre(v))).sum()
        };
        let expected = [
            0.5,
            0.1 * -0.5 + 0.2 * 2.0 + 0.2 * 0.5,
            0.3 * -1.5 + 0.2 * -3.5,
            // The spot between two bins is spread over them: 1/4 more than its place squared.
            0.1 * 0.25 + 0.2 * (4.0 + 0.25) + 0.2 * 0.25,
        ];
        let found = [
            moment(&|_, _| 1.0),
            moment(&|u, _| u),
            moment(&|_, v| v),
            moment(&|u, _| u * u),
        ];
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        }
    }
}
