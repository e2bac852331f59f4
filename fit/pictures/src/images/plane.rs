//! OTF of the ray shift in the mid-air image, in two dimensions: S(c fx cos(theta), c fy) at any
//! frequency.
//!
//! Polygons are transformed in closed form, at every frequency on its own. Bins (from a table of
//! rays, or from an interpolation between directions) are transformed once, on a lattice of
//! frequencies, as two products of small matrices. Between the points of the lattice, S is
//! interpolated.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;
use tables::Direction;

use edges::numerics::lagrange;
use edges::numerics::sinc;

/// Points of the lattice per cycle of the fastest phase.
///
/// With shifts up to rho along an axis, the phase of S turns by at most TAU rho step = pi/10 in one
/// step. Lagrange's polynomial of six points errs by (pi/10)^6 x (0.5 x 1.5 x 2.5)^2/720 = 4.7e-6
/// in the middle, along each of two axes.
const STEPS: f64 = 20.0;

/// OTF S of the ray shift over the plane of frequencies.
#[derive(Debug, Clone)]
pub(crate) struct ShiftPlane {
    source: Source,
    /// Millimetres in the mid-air image per edge length of shift, (tangential, sagittal).
    scale: [f64; 2],
    /// Length of the longest shift in the mid-air image, mm.
    reach_mm: f64,
}

/// Form in which the distribution of shifts is kept.
#[derive(Debug, Clone)]
enum Source {
    /// Direction of an exact table, transformed at each frequency.
    Polygons(Box<Direction>),
    /// OTF of bins, tabulated.
    Lattice(Lattice),
}

impl ShiftPlane {
    /// Prepares S for a direction that returns light.
    ///
    /// `cosine` is the cosine of the incidence, outside the sheet. The lattice of bins ends at
    /// `finest_per_mm`, and S is taken as 0 beyond it.
    pub(crate) fn new(
        direction: &Direction,
        cosine: f64,
        c_mm: f64,
        finest_per_mm: f64,
    ) -> ShiftPlane {
        let scale = [c_mm * cosine, c_mm];
        let corners = corners(direction);
        let reach_mm = corners
            .iter()
            .map(|r| (r[0] * scale[0]).hypot(r[1] * scale[1]))
            .fold(0.0, f64::max);
        let source = if direction.paths.is_some() {
            Source::Polygons(Box::new(direction.clone()))
        } else {
            let ends = scale.map(|scale| finest_per_mm * scale);
            Source::Lattice(Lattice::new(direction, &corners, ends))
        };
        ShiftPlane {
            source,
            scale,
            reach_mm,
        }
    }

    /// Returns the length of the longest shift, mm.
    pub(crate) fn reach_mm(&self) -> f64 {
        self.reach_mm
    }

    /// Evaluates S at a frequency (tangential, sagittal), 1/mm.
    ///
    /// The error is 1e-13 for polygons and 1e-5 for bins.
    pub(crate) fn otf(&self, frequency: [f64; 2]) -> Complex64 {
        let kappa = [frequency[0] * self.scale[0], frequency[1] * self.scale[1]];
        match &self.source {
            Source::Polygons(direction) => direction.otf_along(kappa, &[1.0])[0],
            Source::Lattice(lattice) => lattice.at(kappa),
        }
    }
}

/// Returns shifts whose convex hull contains all shifts, edge lengths.
///
/// They are the corners of the shifted polygons, or the corners of the bins that are not empty.
fn corners(direction: &Direction) -> Vec<[f64; 2]> {
    if let Some(paths) = &direction.paths {
        let shifted = paths
            .iter()
            .flat_map(|path| path.polygon.iter().map(|&entry| path.shift(entry)));
        return shifted.collect();
    }
    let width = width(direction);
    let edge = |i: usize| i as f64 * width - direction.range;
    direction
        .probability
        .indexed_iter()
        .filter(|&(_, &p)| p > 0.0)
        .flat_map(|((v, u), _)| {
            [[u, v], [u + 1, v], [u, v + 1], [u + 1, v + 1]].map(|[u, v]| [edge(u), edge(v)])
        })
        .collect()
}

/// Returns the width of a bin, edge lengths.
fn width(direction: &Direction) -> f64 {
    2.0 * direction.range / direction.probability.ncols() as f64
}

/// OTF S of bins at the points of a lattice of kappa (cycles per edge length), row-major, for
/// kappa_v >= 0.
#[derive(Debug, Clone)]
struct Lattice {
    /// Distance between points of the lattice, cycles per edge length.
    step: [f64; 2],
    /// Column of kappa_u = 0. Columns run from -half to half, rows from -[`MARGIN`].
    half: usize,
    /// Count of rows.
    rows: usize,
    values: Vec<Complex64>,
}

/// Points of the lattice that the interpolation needs beyond the last frequency, and below 0.
const MARGIN: usize = 3;

impl Lattice {
    fn new(direction: &Direction, corners: &[[f64; 2]], ends: [f64; 2]) -> Lattice {
        let farthest = |axis: usize| corners.iter().map(|r| r[axis].abs()).fold(1e-3, f64::max);
        let step = [0, 1].map(|axis| 1.0 / (STEPS * farthest(axis)));
        let half = (ends[0] / step[0]).ceil() as usize + MARGIN;
        let rows = (ends[1] / step[1]).ceil() as usize + 2 * MARGIN;
        let total = direction.probability.sum();
        let bins = direction.probability.ncols();
        let width = width(direction);
        let centre = |i: usize| (i as f64 + 0.5) * width - direction.range;
        // Along u first: every row of the lattice uses these sums.
        let columns = 2 * half + 1;
        let wave = |kappa: f64, i: usize| {
            Complex64::cis(-TAU * kappa * centre(i)) * sinc(PI * kappa * width)
        };
        let across: Vec<Complex64> = (0..bins)
            .flat_map(|u| (0..columns).map(move |x| wave((x as f64 - half as f64) * step[0], u)))
            .collect();
        let mut partial = vec![Complex64::ZERO; bins * columns];
        for ((v, u), &p) in direction.probability.indexed_iter() {
            if p > 0.0 {
                let row = &mut partial[v * columns..][..columns];
                for (sum, wave) in row.iter_mut().zip(&across[u * columns..]) {
                    *sum += wave * (p / total);
                }
            }
        }
        let mut values = vec![Complex64::ZERO; rows * columns];
        for (y, row) in values.chunks_exact_mut(columns).enumerate() {
            let kappa = (y as f64 - MARGIN as f64) * step[1];
            for (v, partial) in partial.chunks_exact(columns).enumerate() {
                let wave = wave(kappa, v);
                for (value, part) in row.iter_mut().zip(partial) {
                    *value += wave * part;
                }
            }
        }
        Lattice {
            step,
            half,
            rows,
            values,
        }
    }

    /// Interpolates S at a point of the plane, cycles per edge length; 0 beyond the lattice.
    fn at(&self, kappa: [f64; 2]) -> Complex64 {
        // The distribution is real, so S(-kappa) is the conjugate of S(kappa).
        if kappa[1] < 0.0 {
            return self.at(kappa.map(|k| -k)).conj();
        }
        let x = kappa[0] / self.step[0] + self.half as f64;
        let y = kappa[1] / self.step[1] + MARGIN as f64;
        let columns = 2 * self.half + 1;
        let within = |at: f64, count: usize| at >= 2.0 && at < count as f64 - 3.0;
        if !within(x, columns) || !within(y, self.rows) {
            return Complex64::ZERO;
        }
        let (left, top) = (x as usize - 2, y as usize - 2);
        let (across, down) = (lagrange(x - x.floor()), lagrange(y - y.floor()));
        let mut sum = Complex64::ZERO;
        for (i, weight) in down.iter().enumerate() {
            let row = &self.values[(top + i) * columns + left..][..6];
            let mut part = Complex64::ZERO;
            for (value, weight) in row.iter().zip(&across) {
                part += value * weight;
            }
            sum += part * weight;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    /// Returns a direction with bins of a lopsided distribution, filled up to the corners of the
    /// range.
    fn lumpy() -> Direction {
        let probability = Array2::from_shape_fn((32, 32), |(v, u)| {
            ((v * 7 + u * 13) % 11) as f64 * ((u + v) % 5) as f64 * 1e-3
        });
        Direction {
            incidence_deg: 25.0,
            azimuth_deg: 0.0,
            retroreflected: probability.sum(),
            probability,
            range: 2.0,
            standard_error: 0.0,
            interpolated: true,
            paths: None,
            exits: None,
        }
    }

    #[test]
    fn the_lattice_meets_the_bins_own_transform() {
        let direction = lumpy();
        let (c, cosine) = (0.24, 25.0_f64.to_radians().cos());
        let plane = ShiftPlane::new(&direction, cosine, c, 12.0);
        let mut worst: f64 = 0.0;
        for i in 0..400 {
            let angle = f64::from(i) * 2.399_963;
            let f = 12.0 * f64::from(i) / 400.0;
            let frequency = [f * angle.cos(), f * angle.sin()];
            let along = [frequency[0] * c * cosine, frequency[1] * c];
            let expected = direction.otf_of_bins_along(along, &[1.0]).0[0];
            worst = worst.max((plane.otf(frequency) - expected).norm());
        }
        // The error is 4.7e-6 along each axis. The absolute weights of the other axis sum to at
        // most 1.6.
        assert!(worst < 2.0 * 4.7e-6 * 1.6, "{worst}");
        assert_eq!(plane.otf([40.0, 0.0]), Complex64::ZERO);
        let corner = (2.0 * c * cosine).hypot(2.0 * c);
        assert!((plane.reach_mm() - corner).abs() < 1e-12);
    }
}
