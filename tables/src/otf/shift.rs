//! Ray shift in the mid-air image: a direction of a table seen along an edge normal.
//!
//! Light of cubes that are not exact has deviations. It meets the image plane off by R times its
//! deviation besides the shift. A deviation is an angle: its effect grows with the distance and not
//! with the corner size. Each polygon has one deviation; in a table of rays the bins have them
//! (`spots`).

use crate::lookup::direction::Direction;
use crate::lookup::sextants::Sextant;
use crate::otf::hermite::Samples;
use crate::otf::ruling::Ruling;
use crate::otf::spots;
use crate::table::exact::Path;
use crate::table::polygon::area;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Deviations that differ by less than this count as equal, rad: 0.1 nm at a distance of 1 m.
const SAME_DEVIATION: f64 = 1e-10;

/// Derivatives of a deviation by a dihedral error that differ by less than this count as equal.
const SAME_SLOPE: f64 = 1e-9;

/// OTF of the shift along one line: S(c f) for an edge normal in the mid-air image.
#[derive(Debug, Clone)]
pub struct ShiftLine {
    spots: Vec<LineSpot>,
}

impl ShiftLine {
    /// Prepares the line of an edge normal, or returns `None` if nothing is retroreflected.
    ///
    /// `normal` is the unit edge normal in the mid-air image, (tangential, sagittal).
    /// `incidence_rad` is the incidence outside, which foreshortens the tangential shift.
    pub fn new(direction: &Direction, incidence_rad: f64, normal: [f64; 2]) -> Option<ShiftLine> {
        if direction.retroreflected <= 0.0 {
            return None;
        }
        let along = [normal[0] * incidence_rad.cos(), normal[1]];
        let whole = |path: &Path| Sextant {
            path: path.clone(),
            by_error: [[0.0; 2]; 3],
        };
        let paths = direction.paths.as_deref().unwrap_or_default();
        let spots = match &direction.exits {
            Some(exits) => spots::spots(direction, exits, normal, along),
            // A table of bins without deviations.
            None if paths.is_empty() => {
                let ruling = Ruling::of_bins(direction, along);
                vec![LineSpot {
                    share: 1.0,
                    deviation: 0.0,
                    by_error: [0.0; 3],
                    middle: ruling.middle,
                    samples: ruling.samples(direction, along),
                }]
            }
            None => of_paths(paths.iter().map(whole).collect(), direction, normal, along),
        };
        Some(ShiftLine { spots })
    }

    /// Prepares the same line for cubes with dihedral errors: for [`ShiftLine::otf_with_errors`].
    /// `index` is that of the sheet. Returns `None` also if the table does not say which cubes its
    /// paths belong to.
    pub fn with_errors(
        direction: &Direction,
        incidence_rad: f64,
        normal: [f64; 2],
        index: f64,
    ) -> Option<ShiftLine> {
        if direction.retroreflected <= 0.0 || direction.exits.is_some() {
            return None;
        }
        let along = [normal[0] * incidence_rad.cos(), normal[1]];
        let sextants = direction.sextants(index)?;
        Some(ShiftLine {
            spots: of_paths(sextants, direction, normal, along),
        })
    }

    /// Returns the OTF and its derivative by `c` (mm) at a frequency in 1/mm, at the distance
    /// `r_mm`.
    ///
    /// Both are 0 beyond c f = 16: lobes and cameras pass nothing there for cells up to 1 mm and
    /// frequencies up to 16 /mm. The OTF is accurate to 1.6e-5 (`ruling`).
    pub fn otf(&self, c: f64, r_mm: f64, frequency: f64) -> (Complex64, Complex64) {
        let [value, by_c, ..] = self.otf_with_errors([c, r_mm], [0.0; 3], frequency);
        (value, by_c)
    }

    /// Returns the OTF of cubes whose dihedral angles have these errors at the edges 1, 2 and 3 (see
    /// [`Direction::bent`]), rad, and its derivatives by `c` and by the errors. The line has to be one
    /// of [`ShiftLine::with_errors`]; errors do nothing to others.
    pub fn otf_with_errors(
        &self,
        [c, r_mm]: [f64; 2],
        errors_rad: [f64; 3],
        frequency: f64,
    ) -> [Complex64; 5] {
        let kappa = c * frequency;
        let mut sums = [Complex64::ZERO; 5];
        for spot in &self.spots {
            if kappa > spot.samples.end() {
                continue;
            }
            let (here, slope) = spot.samples.at(kappa);
            let by_errors = errors_rad.into_iter().zip(spot.by_error);
            let bent: f64 = by_errors.map(|(error, by)| error * by).sum();
            let off_mm = r_mm * (spot.deviation + bent) + c * spot.middle;
            if off_mm == 0.0 && spot.by_error == [0.0; 3] {
                sums[0] += here * spot.share;
                sums[1] += slope * (frequency * spot.share);
                continue;
            }
            let turn = Complex64::cis(-TAU * frequency * off_mm) * spot.share;
            let turning = Complex64::new(0.0, -TAU * spot.middle);
            sums[0] += here * turn;
            sums[1] += (slope + here * turning) * turn * frequency;
            let by_off = Complex64::new(0.0, -TAU * frequency * r_mm) * here * turn;
            for (sum, by) in sums[2..].iter_mut().zip(spot.by_error) {
                *sum += by_off * by;
            }
        }
        sums
    }
}

/// Returns the spots of paths, those together that leave in one direction whatever the errors.
fn of_paths(
    paths: Vec<Sextant>,
    direction: &Direction,
    normal: [f64; 2],
    along: [f64; 2],
) -> Vec<LineSpot> {
    let mut groups: Vec<Vec<Sextant>> = Vec::new();
    for path in paths {
        let same = |group: &&mut Vec<Sextant>| {
            let apart = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
            group.first().is_some_and(|first| {
                let mut pairs = first.by_error.iter().zip(&path.by_error);
                apart(&first.path.deviation, &path.path.deviation) < SAME_DEVIATION
                    && pairs.all(|(a, b)| apart(a, b) < SAME_SLOPE)
            })
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push(path),
            None => groups.push(vec![path]),
        }
    }
    let power = |paths: &[Sextant]| {
        let each = paths.iter();
        each.map(|s| s.path.weight * area(&s.path.polygon))
            .sum::<f64>()
    };
    let total: f64 = groups.iter().map(|group| power(group)).sum();
    let projected = |[across, v]: [f64; 2]| normal[0] * across + normal[1] * v;
    let spot = |group: Vec<Sextant>| {
        let share = power(&group) / total;
        let deviation = projected(group[0].path.deviation);
        let by_error = group[0].by_error.map(projected);
        let group: Vec<Path> = group.into_iter().map(|sextant| sextant.path).collect();
        let ruling = Ruling::of_paths(&group, along);
        let own = Direction {
            paths: Some(group),
            ..direction.clone()
        };
        LineSpot {
            share,
            deviation,
            by_error,
            middle: ruling.middle,
            samples: ruling.samples(&own, along),
        }
    };
    groups.into_iter().map(spot).collect()
}

/// Light that leaves in one direction.
#[derive(Debug, Clone)]
pub(crate) struct LineSpot {
    /// Factor of the samples.
    pub share: f64,
    /// Tangent of the deviation along the edge normal.
    pub deviation: f64,
    /// Derivatives of this tangent by the dihedral errors.
    pub by_error: [f64; 3],
    /// Shift along the edge normal that the samples leave out, edge lengths.
    pub middle: f64,
    /// OTF as a function of c f.
    pub samples: Samples<Complex64>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    /// Returns a direction at 20 degrees in which these paths return.
    fn of(paths: Vec<Path>) -> Direction {
        Direction {
            incidence_deg: 20.0,
            azimuth_deg: 0.0,
            retroreflected: 0.4,
            probability: Array2::zeros((4, 4)),
            range: 2.0,
            standard_error: 0.0,
            interpolated: false,
            exits: None,
            paths: Some(paths),
        }
    }

    /// Compares two ways to the OTF of three triangles, two of which leave in one direction: spots
    /// in turn, and deviations made part of the shift at one distance and corner size.
    ///
    /// The derivative is compared with differences.
    #[test]
    fn deviations_are_shifts_that_grow_with_the_distance() {
        let path = |x: f64, weight: f64, deviation: [f64; 2]| Path {
            polygon: vec![[x, 0.0], [x + 0.5, 0.1], [x + 0.2, 0.6]],
            matrix: [[-2.0, 0.01], [0.02, -2.0]],
            offset: [2.0 * x + 0.5, 0.4],
            weight,
            deviation,
            passes: 0,
            jones: None,
            cube: None,
        };
        let direction = of(vec![
            path(0.0, 0.9, [1e-3, -2e-3]),
            path(1.0, 0.7, [-1e-3, 5e-4]),
            path(2.0, 0.8, [1e-3, -2e-3]),
        ]);
        let incidence = 20_f64.to_radians();
        let mut cases = 0;
        for normal in [[1.0, 0.0], [0.6, 0.8]] {
            let line = ShiftLine::new(&direction, incidence, normal).expect("light returns");
            assert_eq!(line.spots.len(), 2);
            for (c, r) in [(0.1, 100.0), (0.3, 400.0)] {
                let moved = direction.clone().seen_from(r, c, incidence.cos()).unwrap();
                let along = [normal[0] * incidence.cos(), normal[1]];
                for f in [0.0, 0.2, 0.9, 2.3] {
                    let (value, by_c) = line.otf(c, r, f);
                    let expected = moved.otf_along(along, &[c * f])[0];
                    // Error of the interpolation.
                    assert!((value - expected).norm() < 1.5e-5, "{value} {expected}");
                    let step = 1e-5;
                    let slope =
                        (line.otf(c + step, r, f).0 - line.otf(c - step, r, f).0) / (2.0 * step);
                    // Differences of a cubic: f^3 step^2 x (2 pi 2.83)^3/6, and rounding over the
                    // step.
                    assert!((by_c - slope).norm() < 1e-5, "{by_c} {slope}");
                    cases += 1;
                }
            }
        }
        assert_eq!(cases, 16);
    }

    /// Compares a line with dihedral errors with that of the direction that has them, and its derivatives
    /// with differences. A step s of an error turns a phase by 2 pi f R d s, with d up to 5: differences
    /// err by (2 pi f R d)^3 s^2 / 6, 2.6e-4 per rad at most here, and rounding over s; 1e-6 per mrad is
    /// allowed. Those by c err as in the test above.
    #[test]
    fn lines_with_errors_are_those_of_bent_directions() {
        let (root, low) = (f64::sqrt(2.0 / 3.0), f64::sqrt(1.0 / 3.0));
        let edge = |turn: f64| {
            let (sine, cosine) = (turn.to_radians()).sin_cos();
            [root * cosine, root * sine, low]
        };
        let hexagon = (0..6).map(|k| {
            let (sine, cosine) = f64::from(k).mul_add(TAU / 6.0, 0.2).sin_cos();
            [1.0 + 0.5 * cosine, 0.4 * sine]
        });
        let path = Path {
            polygon: hexagon.collect(),
            matrix: [[-2.0, 0.0], [0.0, -2.0]],
            offset: [2.0, 0.1],
            weight: 0.8,
            deviation: [1e-4, 0.0],
            passes: 0,
            jones: None,
            cube: Some([edge(250.0), edge(10.0), edge(130.0)]),
        };
        let direction = of(vec![path]);
        let (theta, index, errors) = (20_f64.to_radians(), 1.49, [3e-5, -2e-5, 6e-5]);
        let mut cases = 0;
        for normal in [[1.0, 0.0], [0.6, 0.8]] {
            let line = ShiftLine::with_errors(&direction, theta, normal, index).expect("a cube");
            let bent = direction.bent(errors, index).expect("a cube");
            let bent = ShiftLine::new(&bent, theta, normal).expect("light returns");
            let plain = ShiftLine::new(&direction, theta, normal).expect("light returns");
            assert_eq!(line.spots.len(), 6);
            for (c, r, f) in [(0.1, 100.0, 0.4), (0.3, 400.0, 0.9), (0.3, 400.0, 2.0)] {
                let at = |c, errors| line.otf_with_errors([c, r], errors, f);
                let found = at(c, errors);
                // Both interpolate their samples.
                assert!((found[0] - bent.otf(c, r, f).0).norm() < 3.2e-5);
                assert!((at(c, [0.0; 3])[0] - plain.otf(c, r, f).0).norm() < 3.2e-5);
                let step = 1e-5;
                let slope = (at(c + step, errors)[0] - at(c - step, errors)[0]) / (2.0 * step);
                assert!((found[1] - slope).norm() < 1e-5, "{} {slope}", found[1]);
                for k in 0..3 {
                    let step = 1e-8;
                    let side = |by: f64| {
                        let mut errors = errors;
                        errors[k] += by;
                        at(c, errors)[0]
                    };
                    let slope = (side(step) - side(-step)) / (2.0 * step);
                    let off = 1e-3 * (found[2 + k] - slope).norm();
                    assert!(off < 1e-6, "{} {slope}", found[2 + k]);
                    cases += 1;
                }
            }
        }
        assert_eq!(cases, 18);
    }

    /// Compares far shifts of up to 30 edge lengths, together or apart, with the OTF of the
    /// polygons or of the bins.
    #[test]
    fn far_shifts_are_as_good_as_near_ones() {
        let path = |offset: [f64; 2]| Path {
            polygon: vec![[0.0, 0.0], [0.5, 0.1], [0.2, 0.6]],
            matrix: [[-2.0, 0.0], [0.0, -2.0]],
            offset,
            weight: 1.0,
            deviation: [0.0; 2],
            passes: 0,
            jones: None,
            cube: None,
        };
        let at = |offsets: &[[f64; 2]]| of(offsets.iter().copied().map(path).collect());
        let bins = Direction {
            probability: Array2::from_shape_fn((48, 48), |(v, u)| ((v * 7 + u * 13) % 11) as f64),
            range: 8.0,
            paths: None,
            ..of(Vec::new())
        };
        let incidence = 20_f64.to_radians();
        let (mut cases, mut worst) = (0, 0.0_f64);
        for direction in [
            at(&[[3.0, -3.0]]),
            at(&[[30.0, 0.0], [29.5, 1.0]]),
            at(&[[-21.0, 21.0]]),
            at(&[[30.0, 0.0], [-30.0, 4.0], [0.0, 9.0]]),
            bins,
        ] {
            for normal in [[1.0, 0.0], [0.6, 0.8], [0.0, -1.0]] {
                let along = [normal[0] * incidence.cos(), normal[1]];
                let line = ShiftLine::new(&direction, incidence, normal).expect("light returns");
                for k in 0..200 {
                    let (c, f) = (0.4, 0.0337 * f64::from(k));
                    let (value, by_c) = line.otf(c, 300.0, f);
                    let (expected, slope) = direction.otf_and_slope_along(along, &[c * f]);
                    worst = worst.max((value - expected[0]).norm());
                    // Slopes are up to 2 pi 32. The slope of a cubic errs by (2 pi 2.83)^4 x step^3
                    // x sqrt 3/216, 3.1e-3. Light 64 edge lengths apart has a twelfth of the step,
                    // which makes it 12 times as much. The slope of the phase errs by 2 pi 32 x
                    // 1.6e-5.
                    let off = (by_c - slope[0] * f).norm();
                    assert!(off <= 0.041 * f, "{normal:?} {f}: {by_c} {slope:?}");
                    cases += 1;
                }
            }
        }
        println!("{cases} values within {worst:.1e}");
        assert!(worst < 1.6e-5, "{worst}");
        assert_eq!(cases, 3000);
    }
}
