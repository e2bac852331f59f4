//! Deviations as a part of the shift, for one distance and one size of the cells.

use ndarray::Array2;

use crate::error::Error;
use crate::lookup::direction::Direction;
use crate::table::deviation::Exits;
use crate::table::exact::Path;

/// Most bins along each axis, 32 MB in all; bins are pooled beyond it.
const MOST_BINS: usize = 2048;

/// Greatest number of moves of a bin by a deviation.
///
/// Lobes in 128 x 128 bins, pooled to 16 x 16 cells of 127 x 127 deviations, have up to 2.6e8. The
/// moves that are allowed take some ten seconds.
const MOST_MOVES: u64 = 1 << 32;

/// Number of empty bins at each end, because light is shared out to the neighbours of its bin.
const MARGIN: usize = 2;

/// Greatest distance by which light may be off, edge lengths.
///
/// It is 10 m with half a radian and corners of 5 um. A greater value is a slip in a file.
const FARTHEST: f64 = 1e6;

impl Direction {
    /// Returns the direction with its deviations made part of the shifts.
    ///
    /// The light of each ray is shifted by `per_tangent` (u, v; edge lengths) times its deviation,
    /// besides its own shift. It then leaves straight back.
    ///
    /// Polygons are moved. Bins are moved onto a wider histogram, and each is shared out among the
    /// four bins around its place. At kappa per edge length this takes (2 pi kappa width)^2/12 from
    /// an OTF, half of what the bins themselves take. Beyond about a thousand bins from the middle,
    /// bins are pooled and the width is that of the pooled bins, a thousandth of the farthest
    /// shift.
    ///
    /// # Errors
    /// Returns an [`Error`] if light would be off by more than a million edge lengths, or if there
    /// are too many bins and deviations.
    pub fn moved(self, per_tangent: [f64; 2]) -> Result<Direction, Error> {
        let edges = self.farthest_move(per_tangent);
        if edges > FARTHEST {
            return Err(Error::Direction(format!(
                "at this distance and corner size light would be off by {edges:.1e} edge lengths, \
                above the limit of 1e6; check the distance, and c_mm of the result"
            )));
        }
        let (probability, range) = match &self.exits {
            Some(exits) if moves(&self.probability, exits) > MOST_MOVES => {
                let (incidence_deg, bins) = (self.incidence_deg, self.probability.ncols());
                return Err(Error::Direction(format!(
                    "the table spreads the light at incidence {incidence_deg} deg over too many \
                    bins ({bins} x {bins}) and exit directions; bake it with fewer --bins"
                )));
            }
            Some(exits) => bins(&self, exits, per_tangent, edges),
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
        Ok(Direction {
            probability,
            range,
            exits: None,
            paths: self
                .paths
                .map(|paths| paths.into_iter().map(path).collect()),
            ..self
        })
    }

    /// Returns the direction as it is seen from the distance `r_mm` with the corner size `c_mm`.
    ///
    /// The deviation at that distance becomes part of the shift. `cosine` is that of the incidence
    /// outside.
    ///
    /// # Errors
    /// Returns the errors of [`Direction::moved`].
    pub fn seen_from(self, r_mm: f64, c_mm: f64, cosine: f64) -> Result<Direction, Error> {
        self.moved([r_mm / (c_mm * cosine), r_mm / c_mm])
    }

    /// Returns the largest component of all moves, edge lengths; infinite if `per_tangent` is not
    /// finite.
    fn farthest_move(&self, per_tangent: [f64; 2]) -> f64 {
        if !per_tangent.iter().all(|by| by.is_finite()) {
            return f64::INFINITY;
        }
        let paths = self.paths.iter().flatten().map(|path| path.deviation);
        let exits = self.exits.iter().flat_map(|exits| {
            let bin = |&(place, _): &(u64, f64)| exits.grid.deviation(exits.grid.at(place).1);
            exits.probability.iter().map(bin)
        });
        let along = |deviation: [f64; 2]| {
            let [u, v] = [0, 1].map(|k| (per_tangent[k] * deviation[k]).abs());
            u.max(v)
        };
        paths.chain(exits).map(along).fold(0.0, f64::max)
    }
}

/// Returns the number of bins that are moved, each by all deviations of its cell.
fn moves(bins: &Array2<f64>, exits: &Exits) -> u64 {
    let pool = (bins.ncols() / exits.grid.cells) as u64;
    pool * pool * exits.probability.len() as u64
}

/// Returns the histogram of shifts with the deviations in it, and its range.
///
/// `per_tangent` (u, v) is in edge lengths and moves light by at most `farthest` along an axis.
fn bins(
    direction: &Direction,
    exits: &Exits,
    per_tangent: [f64; 2],
    farthest: f64,
) -> (Array2<f64>, f64) {
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
    let reach = shift.fold(0.0, f64::max) + farthest;
    let pooled = (reach / width / (MOST_BINS / 2 - MARGIN) as f64).ceil();
    let step = width * pooled.max(1.0);
    let half = (reach / step).ceil() as usize + MARGIN;
    let (range, count) = (step * half as f64, 2 * half);
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
    use crate::table::deviation::Grid;

    /// Returns a direction with two bins and three spots between them.
    fn two_bins() -> Direction {
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
        Direction {
            incidence_deg: 0.0,
            azimuth_deg: 0.0,
            retroreflected: 0.5,
            probability,
            range: 2.0,
            standard_error: 0.0,
            interpolated: false,
            paths: None,
            exits: Some(exits),
        }
    }

    fn width(direction: &Direction) -> f64 {
        2.0 * direction.range / direction.probability.ncols() as f64
    }

    /// Returns the sum over the bins of their content times a function of their place (u, v).
    fn moment(direction: &Direction, of: impl Fn(f64, f64) -> f64) -> f64 {
        let centre = |k: usize| (k as f64 + 0.5) * width(direction) - direction.range;
        let cells = direction.probability.indexed_iter();
        cells.map(|((v, u), p)| p * of(centre(u), centre(v))).sum()
    }

    /// Compares masses and their mean places with those calculated by hand.
    #[test]
    fn bins_go_where_their_light_goes() {
        // The bins of deviation are 2 mrad wide: the second spot is moved by 2.5 along u, the third
        // by -5 along v.
        let moved = two_bins().moved([1250.0, 2500.0]).unwrap();
        assert!(moved.exits.is_none() && moved.paths.is_none());
        assert!((width(&moved) - 1.0).abs() < 1e-15);
        let expected = [
            0.5,
            0.1 * -0.5 + 0.2 * 2.0 + 0.2 * 0.5,
            0.3 * -1.5 + 0.2 * -3.5,
            // The spot between two bins is spread over them, which adds 1/4 to the square of its
            // place.
            0.1 * 0.25 + 0.2 * (4.0 + 0.25) + 0.2 * 0.25,
        ];
        let found = [
            moment(&moved, |_, _| 1.0),
            moment(&moved, |u, _| u),
            moment(&moved, |_, v| v),
            moment(&moved, |u, _| u * u),
        ];
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        }
    }

    /// Checks that no light is lost when it is moved so far that bins are pooled, and that its mean
    /// place stays right, up to the greatest distance that is allowed.
    #[test]
    fn pooled_bins_lose_nothing() {
        let (mut cases, mut widest) = (0, 0.0_f64);
        for by in [1e3, 1022.5, 2.5e3, 4.0e3, 6.5e3, 1e4, 9.9e5] {
            for towards in [[1.0, 1.0], [1.0, -0.7], [-1.0, 0.3]] {
                let moved = two_bins()
                    .moved(towards.map(|part| part * by / 2e-3))
                    .unwrap();
                assert!(moved.probability.ncols() <= MOST_BINS);
                let [u, v] = towards.map(|part| part * by);
                let expected = [
                    0.5,
                    0.1 * -0.5 + 0.2 * (u - 0.5) + 0.2 * 0.5,
                    0.3 * -1.5 + 0.2 * (1.5 - v),
                ];
                let found = [
                    moment(&moved, |_, _| 1.0),
                    moment(&moved, |u, _| u),
                    moment(&moved, |_, v| v),
                ];
                // Masses are rounded, and so are places of up to `by`.
                let allowed = [1e-15, 1e-14 * by, 1e-14 * by];
                for k in 0..3 {
                    let (found, expected) = (found[k], expected[k]);
                    assert!((found - expected).abs() < allowed[k], "{found} {expected}");
                }
                widest = widest.max(width(&moved));
                cases += 1;
            }
        }
        assert_eq!(cases, 21);
        assert!(widest > 900.0, "a million edge lengths in a thousand bins");
    }

    #[test]
    fn what_is_off_by_a_million_edges_is_refused() {
        let tiny = 1.0 / f64::MIN_POSITIVE;
        for by in [1e9, tiny, 1e306, f64::INFINITY, f64::NAN] {
            let error = two_bins().moved([0.0, by]).unwrap_err().to_string();
            assert!(error.contains("c_mm"), "{error}");
        }
        // Light without deviation is not moved, however small the corners.
        let straight = Direction {
            exits: None,
            ..two_bins()
        };
        assert!(straight.clone().moved([1e300; 2]).is_ok());
        assert!(straight.moved([f64::INFINITY; 2]).is_err());
    }
}
