//! Exit directions of a table of rays along a line: spots, or a row of spots in place of a lobe.
//!
//! The bins of shift that belong to a spot are first projected on the line, onto a fine grid; one
//! FFT then gives their OTF. A transform of all bins in two dimensions, for as many as
//! [`MOST_SPOTS`] spots, would take a second for each photograph.
//!
//! All rays of one cell of shifts are given the histogram of the cell, whatever their deviation.
//! This is exact where each cell is one bin, as for planar facets. A deviation is known only to a
//! bin of width w. So at the frequency f and the distance R the OTF of a lobe lacks a factor of
//! sinc(f R w), 1 - 1.6 (f R w)^2.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use num_complex::Complex64;
use transforms::Real;

use crate::lookup::direction::Direction;
use crate::otf::hermite::Samples;
use crate::otf::polygon_wave::sinc;
use crate::otf::ruling::{Ruling, STEP};
use crate::otf::shift::LineSpot;
use crate::table::deviation::Exits;

/// Most exit directions that have a spot each; more become a row of evenly spaced spots.
const MOST_SPOTS: usize = 96;

/// Number of spots in such a row.
///
/// For a lobe of width w the phase turns by 2 pi f R w/192 from one spot to the next. Lagrange's
/// cubic loses the fourth power of it times 3/128: 2e-5 where f R w is 5.
const MOST_IN_A_ROW: usize = 192;

/// Number of points of the grid along the line where shifts are near.
///
/// The number is multiplied where the spacing in kappa is finer. The grid covers 1/step edge
/// lengths. The tabulated kappa are multiples of the step, so a shift beyond the grid is equivalent
/// to one on it. A shift is put on four points by Lagrange's cubic, whose error is (TAU kappa
/// spacing)^4 x 3/128: 1e-7 up to kappa = 4, 4e-5 at the end.
const POINTS: usize = 1 << 15;

/// Spreads a place along a line over four places of an even grid of this spacing.
///
/// Returns the first of them and the four weights.
fn on_grid(x: f64, spacing: f64) -> (i64, [f64; 4]) {
    let at = x / spacing;
    let t = at - at.floor();
    let weights = [
        -t * (t - 1.0) * (t - 2.0) / 6.0,
        (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
        -(t + 1.0) * t * (t - 2.0) / 2.0,
        (t + 1.0) * t * (t - 1.0) / 6.0,
    ];
    (at.floor() as i64 - 1, weights)
}

/// Returns the spots of a direction; `normal` is the edge normal, and `along` is the normal
/// foreshortened for shifts.
pub(crate) fn spots(
    direction: &Direction,
    exits: &Exits,
    normal: [f64; 2],
    along: [f64; 2],
) -> Vec<LineSpot> {
    let total: f64 = exits.probability.iter().map(|(_, p)| p).sum();
    let width = 2.0 * direction.range / direction.probability.ncols() as f64;
    let ruling = Ruling::of_bins(direction, along);
    let cut = Cut {
        direction,
        pool: direction.probability.ncols() / exits.grid.cells,
        width,
        along,
        middle: ruling.middle,
    };
    let points = (POINTS as f64 * ruling.finer) as usize;
    let found = along_normal(exits, normal);
    let mut cells: BTreeMap<[usize; 2], Vec<GridPoint>> = BTreeMap::new();
    for &(cell, _) in found.iter().flat_map(|spot| &spot.light) {
        cells.entry(cell).or_insert_with(|| cut.cell(cell, points));
    }
    let transform = f64::forward(points);
    let boxes = boxes(&ruling, width, along);
    let spot = |spot: &Spot| {
        let mut sums = [vec![0.0; points], vec![0.0; points]];
        for (cell, share) in &spot.light {
            for point in &cells[cell] {
                sums[0][point.index] += share * point.weight;
                sums[1][point.index] += share * point.moment;
            }
        }
        let [values, moments] = sums.map(|mut sums| {
            let mut spectrum = transform.make_output_vec();
            transform
                .process(&mut sums, &mut spectrum)
                .expect("lengths are the plan's");
            spectrum
        });
        let table = boxes.iter().zip(values.iter().zip(&moments));
        let (values, slopes) = table
            .map(|(&(size, slope), (value, moment))| {
                let turning = Complex64::new(0.0, -TAU) * moment;
                (
                    value * (size / total),
                    (turning * size + value * slope) / total,
                )
            })
            .unzip();
        LineSpot {
            share: 1.0,
            deviation: spot.deviation,
            by_error: [0.0; 3],
            middle: ruling.middle,
            samples: Samples::new(ruling.step(), values, slopes),
        }
    };
    found.iter().map(spot).collect()
}

/// Returns the OTF of a bin's box at the tabulated kappa, with its slope.
fn boxes(ruling: &Ruling, width: f64, along: [f64; 2]) -> Vec<(f64, f64)> {
    let at = |kappa: f64| {
        let [(u, by_u), (v, by_v)] = along.map(|along| {
            let per_kappa = PI * along * width;
            let (value, slope) = sinc(per_kappa * kappa);
            (value, slope * per_kappa)
        });
        (u * v, by_u * v + u * by_v)
    };
    ruling.kappa().map(at).collect()
}

/// Point of the grid of shifts: its part of a cell's light, and this part times the shift.
struct GridPoint {
    index: usize,
    weight: f64,
    moment: f64,
}

/// Shifts of a direction, projected on a line.
struct Cut<'a> {
    direction: &'a Direction,
    /// Number of bins along a side of a cell.
    pool: usize,
    width: f64,
    along: [f64; 2],
    /// Shift from which the points are counted, edge lengths.
    middle: f64,
}

impl Cut<'_> {
    /// Projects the bins of a cell on a grid of `count` points along the line.
    fn cell(&self, [v, u]: [usize; 2], count: usize) -> Vec<GridPoint> {
        let bins = &self.direction.probability;
        let inside = || {
            let rows = v * self.pool..(v + 1) * self.pool;
            rows.flat_map(|v| (u * self.pool..(u + 1) * self.pool).map(move |u| (v, u)))
        };
        let power: f64 = inside().map(|at| bins[at]).sum();
        // The spacing does not depend on `count`: more points cover a longer line.
        let spacing = 1.0 / (STEP * POINTS as f64);
        let centre = |i: usize| (i as f64 + 0.5) * self.width - self.direction.range;
        let mut points = Vec::new();
        for (v, u) in inside().filter(|&at| bins[at] > 0.0) {
            let x = self.along[0] * centre(u) + self.along[1] * centre(v) - self.middle;
            let (first, weights) = on_grid(x, spacing);
            for (i, weight) in (first..).zip(weights) {
                let weight = weight * bins[(v, u)] / power;
                points.push(GridPoint {
                    index: i.rem_euclid(count as i64) as usize,
                    weight,
                    moment: weight * x,
                });
            }
        }
        points
    }
}

/// Light that leaves in one direction.
struct Spot {
    /// Tangent of the deviation along the normal.
    deviation: f64,
    /// Cells of shifts, each with its light in this direction per launched ray.
    light: Vec<([usize; 2], f64)>,
}

/// Returns the spots along a normal, or the row of spots in their place.
fn along_normal(exits: &Exits, normal: [f64; 2]) -> Vec<Spot> {
    let grid = &exits.grid;
    let mut bins: Vec<[usize; 2]> = Vec::new();
    for &(place, _) in &exits.probability {
        let (_, bin) = grid.at(place);
        if !bins.contains(&bin) {
            bins.push(bin);
        }
        if bins.len() > MOST_SPOTS {
            break;
        }
    }
    let along = |bin: [usize; 2]| {
        let [across, along_v] = grid.deviation(bin);
        normal[0] * across + normal[1] * along_v
    };
    if bins.len() <= MOST_SPOTS {
        let of = |bin: [usize; 2]| {
            let own = exits.probability.iter().filter_map(|&(place, share)| {
                let (cell, at) = grid.at(place);
                (at == bin).then_some((cell, share))
            });
            Spot {
                deviation: along(bin),
                light: own.collect(),
            }
        };
        return bins.into_iter().map(of).collect();
    }
    let all = exits
        .probability
        .iter()
        .map(|&(place, _)| along(grid.at(place).1));
    let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
        (low.min(at), high.max(at))
    });
    let spacing = grid.bin_width().max((high - low) / MOST_IN_A_ROW as f64);
    let start = on_grid(low, spacing).0;
    let count = (on_grid(high, spacing).0 + 4 - start) as usize;
    let mut row: Vec<BTreeMap<[usize; 2], f64>> = vec![BTreeMap::new(); count];
    for &(place, share) in &exits.probability {
        let (cell, bin) = grid.at(place);
        let (first, weights) = on_grid(along(bin), spacing);
        let own = row[(first - start) as usize..].iter_mut().zip(weights);
        for (cells, weight) in own.filter(|(_, weight)| *weight != 0.0) {
            *cells.entry(cell).or_default() += weight * share;
        }
    }
    let lit = (start..).zip(row).filter(|(_, cells)| !cells.is_empty());
    lit.map(|(i, cells)| Spot {
        deviation: i as f64 * spacing,
        light: cells.into_iter().collect(),
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::otf::shift::ShiftLine;
    use crate::table::deviation::Grid;
    use ndarray::Array2;

    /// Returns the bins of one of 4 x 4 cells: their places and probabilities.
    fn cell(bins: &Array2<f64>, [v, u]: [usize; 2]) -> impl Iterator<Item = ([usize; 2], f64)> {
        let inside = move |(bv, bu): (usize, usize)| [bv / 4, bu / 4] == [v, u];
        bins.indexed_iter()
            .filter(move |(at, _)| inside(*at))
            .map(|((v, u), &p)| ([v, u], p))
    }

    /// Returns light of made-up shares at every third place of a grid, its bins of shift pooled by
    /// 4.
    fn direction(bins: usize, range: f64) -> Direction {
        let grid = Grid {
            cells: 4,
            bins,
            range: 2e-3,
        };
        let mut probability = Array2::from_shape_fn((16, 16), |(v, u)| {
            ((v * 7 + u * 13) % 11) as f64 * ((u + v) % 5) as f64
        });
        let mut exits: Vec<(u64, f64)> = Vec::new();
        for v in 0..4 {
            for u in 0..4 {
                let places = (0..bins * bins).step_by(3).map(|k| [k / bins, k % bins]);
                let places: Vec<u64> = places.map(|bin| grid.place([v, u], bin)).collect();
                let weight = |place: u64| ((place * 31 + 7) % 17) as f64;
                let sum: f64 = places.iter().map(|&place| weight(place)).sum();
                let power = cell(&probability, [v, u]).map(|(_, p)| p).sum::<f64>();
                exits.extend(places.iter().map(|&p| (p, power * weight(p) / sum)));
            }
        }
        let total = 2.0 * probability.sum();
        probability.mapv_inplace(|p| p / total);
        exits.iter_mut().for_each(|(_, p)| *p /= total);
        exits.sort_by_key(|(place, _)| *place);
        Direction {
            incidence_deg: 20.0,
            azimuth_deg: 0.0,
            retroreflected: 0.5,
            probability,
            range,
            standard_error: 0.0,
            interpolated: false,
            paths: None,
            exits: Some(Exits {
                grid,
                probability: exits,
            }),
        }
    }

    /// Compares spots and rows with the plain sum over bins of shift and of deviation.
    ///
    /// The derivative by c is compared with differences.
    #[test]
    fn spots_and_rows_are_the_plain_sum() {
        let incidence = 20_f64.to_radians();
        let (mut cases, mut worst) = (0, [0.0_f64; 2]);
        // Shifts beyond those of cubes are tabulated about a middle and with a finer step.
        for (kind, bins, range) in [(0, 5, 2.0), (1, 21, 2.0), (0, 5, 8.0)] {
            let mut direction = direction(bins, range);
            if range > 2.0 {
                // Light on one side only, so that the middle is not 0.
                let exits = direction.exits.clone().unwrap();
                let grid = exits.grid;
                let left = |place: u64| grid.at(place).0[1] < 2;
                let kept = exits
                    .probability
                    .into_iter()
                    .filter(|&(place, _)| left(place));
                let probability = kept.collect();
                direction.exits = Some(Exits {
                    probability,
                    ..exits
                });
                for ((_, u), p) in direction.probability.indexed_iter_mut() {
                    *p *= f64::from(u8::from(u < 8));
                }
            }
            let (exits, bins) = (direction.exits.as_ref().unwrap(), &direction.probability);
            for normal in [[1.0, 0.0], [0.6, -0.8]] {
                let along = [normal[0] * incidence.cos(), normal[1]];
                let line = ShiftLine::new(&direction, incidence, normal).expect("light returns");
                for (c, r) in [(0.1, 100.0), (0.3, 400.0)] {
                    for f in [0.0, 0.2, 0.9, 2.3] {
                        let mut expected = Complex64::ZERO;
                        let centre = |i: usize| (i as f64 + 0.5) * range / 8.0 - range;
                        for &(place, share) in &exits.probability {
                            let ([cv, cu], bin) = exits.grid.at(place);
                            let [across, along_v] = exits.grid.deviation(bin);
                            let off = r * (normal[0] * across + normal[1] * along_v);
                            let power: f64 = cell(bins, [cv, cu]).map(|(_, p)| p).sum();
                            for (at, p) in cell(bins, [cv, cu]) {
                                let [v, u] = at.map(centre);
                                let x = c * (along[0] * u + along[1] * v) + off;
                                let part = share * p / power / bins.sum();
                                expected += Complex64::cis(-TAU * f * x) * part;
                            }
                        }
                        let size = along.map(|along| sinc(PI * c * f * along * range / 8.0).0);
                        let (value, by_c) = line.otf(c, r, f);
                        let off = (value - expected * size[0] * size[1]).norm();
                        worst[kind] = worst[kind].max(off);
                        let step = 1e-5;
                        let ahead = line.otf(c + step, r, f).0;
                        let slope = (ahead - line.otf(c - step, r, f).0) / (2.0 * step);
                        // The error grows with the third power of the reach, as for polygons.
                        let allowed = 1e-5 * (0.5 * range).powi(3);
                        assert!((by_c - slope).norm() < allowed, "{by_c} {slope}");
                        cases += 1;
                    }
                }
            }
        }
        println!(
            "{cases} values, spots within {:.1e}, rows within {:.1e}",
            worst[0], worst[1]
        );
        // The tabulated kappa allow 1.5e-5, the grid 1e-7.
        assert!(worst[0] < 1.6e-5, "{worst:?}");
        // The phase turns by 2 pi 2.3 x 400 x 4e-3/21 = 1.1 from spot to spot of a row: 1.1^4 x
        // 3/128.
        assert!(worst[1] < 3.5e-2, "{worst:?}");
        assert_eq!(cases, 48);
    }

    /// A lobe of 401 bins becomes a row of spots, and the row turns in phase as the lobe does.
    ///
    /// Its width w is seen at f R w = 5, where Lagrange's cubic may lose (2 pi 5/192)^4 x 3/128.
    #[test]
    fn a_row_of_spots_is_the_lobe() {
        let grid = Grid {
            cells: 1,
            bins: 401,
            range: 2e-3,
        };
        // Five stripes across the lobe, so that half of its light adds up at five turns.
        let weight = |k: usize| 1.0 + (TAU * 5.0 * k as f64 / 400.0).cos();
        let places = (0..401).map(|k| (grid.place([0, 0], [200, k]), weight(k)));
        let exits = Exits {
            grid,
            probability: places.collect(),
        };
        let row = along_normal(&exits, [1.0, 0.0]);
        assert!(row.len() > MOST_SPOTS && row.len() <= 196, "{}", row.len());
        let [low, high] = [0, 400].map(|k| grid.deviation([200, k])[0]);
        let turns = 5.0 / (high - low);
        let turn = |deviation: f64| Complex64::cis(-TAU * turns * deviation);
        let lobe: Complex64 = (0..401)
            .map(|k| turn(grid.deviation([200, k])[0]) * weight(k))
            .sum();
        let light = |spot: &Spot| spot.light.iter().map(|(_, share)| share).sum::<f64>();
        let seen: Complex64 = row.iter().map(|s| turn(s.deviation) * light(s)).sum();
        let total: f64 = (0..401).map(weight).sum();
        let allowed = (TAU * 5.0 / 192.0).powi(4) * 3.0 / 128.0;
        let off = (seen - lobe).norm() / total;
        assert!(off < allowed, "{off:e} {allowed:e}");
        assert!(lobe.norm() > 0.49 * total, "{lobe}");
        // Lagrange's weights sum to 1, so the row holds all light.
        let power: f64 = row.iter().map(light).sum();
        assert!((power / total - 1.0).abs() < 1e-13, "{power} {total}");
    }
}
