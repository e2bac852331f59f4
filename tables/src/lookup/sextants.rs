//! Dihedral errors of all cubes of an exact table, to first order: where the light of each order of
//! facets leaves.
//!
//! Light that meets the planes i, j, k of a cube in this order leaves along R_k R_j R_i d, where R is
//! the reflection in a plane and d the direction of the light inside the sheet. An error e of the
//! angle between two planes turns both normals by e/2, each towards the other. (A turn of the whole
//! cube changes nothing, because R_k R_j R_i = -1.) At the front the part along the sheet is
//! multiplied by the index. So the deviation is linear in the three errors, to first order.
//!
//! The order of the planes follows from the point of entry. Let x_i be the distance of the point from
//! the plane i, relative to the point whose light meets the apex, and s_i the speed at which the light
//! nears the plane. The light meets the plane with the least x_i / s_i first. Three lines through the
//! point of the apex part the polygons into sextants, which leave in different directions.
//!
//! Errors of the second order are left out: 3 e times the deviation. So is the change of the ray shift,
//! by e times the edge length. Light that the front face has sent back, or that has met worn edges,
//! keeps its direction.

use std::f64::consts::PI;

use crate::error::Error;
use crate::lookup::direction::Direction;
use crate::lookup::shape::{back, turned};
use crate::table::exact::{Cube, Path};
use crate::table::polygon::{area, clip};
use crate::table::table::Table;

/// Part of a path whose light meets the planes of a cube in one order, or a path without a cube.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sextant {
    /// The part, with its own deviation.
    pub path: Path,
    /// Derivatives of the deviation by the errors at the edges 1, 2 and 3.
    pub by_error: [[f64; 2]; 3],
}

/// Orders of three planes.
const ORDERS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 2, 0],
    [2, 0, 1],
    [2, 1, 0],
    [1, 0, 2],
    [0, 2, 1],
];

/// Least area of a sextant, square edge lengths: rounding of an empty one.
const NO_AREA: f64 = 1e-14;

impl Direction {
    /// Returns the sextants of all paths, or `None` if no path has a cube. `index` is that of the
    /// sheet.
    pub(crate) fn sextants(&self, index: f64) -> Option<Vec<Sextant>> {
        let paths = self.paths.as_deref()?;
        if paths.iter().all(|path| path.cube.is_none()) {
            return None;
        }
        let sine = self.incidence_deg.to_radians().sin() / index;
        let tangent = sine / (1.0 - sine * sine).sqrt();
        let mut sextants = Vec::new();
        for path in paths {
            let Some((cube, apex)) = path.cube.zip(path.fixed()) else {
                sextants.push(Sextant {
                    path: path.clone(),
                    by_error: [[0.0; 2]; 3],
                });
                continue;
            };
            let cube = numbered(cube, self.azimuth_deg.to_radians());
            for order in ORDERS {
                let polygon = lit(path, &cube, apex, order, tangent);
                if area(&polygon) > NO_AREA {
                    sextants.push(Sextant {
                        path: Path {
                            polygon,
                            ..path.clone()
                        },
                        by_error: by_error(&cube, order, tangent, index),
                    });
                }
            }
        }
        Some(sextants)
    }

    /// Returns the direction of a sheet whose cubes have these errors of the dihedral angles at the
    /// edges 1, 2 and 3, rad, beside those of the table; to first order. `index` is that of the sheet.
    ///
    /// The edges are counted counter-clockwise, seen from the light, from the one nearest to azimuth 0,
    /// or to azimuth 180 for cubes that are turned by half a turn. Returns `None` if the table does
    /// not say which cubes its paths belong to.
    pub fn bent(&self, errors_rad: [f64; 3], index: f64) -> Option<Direction> {
        let bent = |sextant: Sextant| {
            let mut path = sextant.path;
            for (error, by) in errors_rad.into_iter().zip(sextant.by_error) {
                path.deviation = [0, 1].map(|k| path.deviation[k] + error * by[k]);
            }
            path
        };
        let sextants = self.sextants(index)?;
        Some(Direction {
            paths: Some(sextants.into_iter().map(bent).collect()),
            ..self.clone()
        })
    }
}

impl Table {
    /// Returns the table of a sheet whose cubes have these errors, as [`Direction::bent`] has them: from
    /// now on [`Table::direction`] returns directions with errors.
    ///
    /// Its arrays stay those of the cubes without.
    ///
    /// # Errors
    /// Returns [`Error::Cubeless`] if the table does not say which cubes its paths belong to.
    pub fn bent(mut self, errors_rad: [f64; 3]) -> Result<Table, Error> {
        let exact = self.exact.as_ref().filter(|_| !self.axes.is_mean());
        let paths = exact
            .into_iter()
            .flat_map(|exact| exact.paths.iter().flatten());
        if paths.filter(|path| path.cube.is_some()).count() == 0 {
            return Err(Error::Cubeless);
        }
        self.errors_rad = errors_rad;
        Ok(self)
    }
}

/// Returns a cube with its edges counted as [`Direction::bent`] says. `azimuth_rad` is that of the
/// incidence frame.
fn numbered(mut cube: Cube, azimuth_rad: f64) -> Cube {
    // Opposite azimuths are equal, and those of the edges 1, 2, 3 then go back by thirds of them.
    let place = |&[u, v, _]: &[f64; 3]| {
        let [x, y] = turned([u, v], azimuth_rad);
        let back = (-y.atan2(x)).rem_euclid(PI);
        if back > 5.0 / 6.0 * PI {
            back - PI
        } else {
            back
        }
    };
    cube.sort_by(|a, b| place(a).total_cmp(&place(b)));
    cube
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

/// Returns the part of a path's polygon whose light meets the planes in this order.
fn lit(path: &Path, cube: &Cube, apex: [f64; 2], order: [usize; 3], tangent: f64) -> Vec<[f64; 2]> {
    // Distances by u and v, over the speed towards the plane.
    let rate = cube.map(|normal| {
        let speed = -dot(normal, [tangent, 0.0, -1.0]);
        [normal[0] / speed, normal[1] / speed]
    });
    let on = |p: [f64; 2], q: [f64; 2], part: f64| [0, 1].map(|k| p[k] + part * (q[k] - p[k]));
    let before = |corners: &[[f64; 2]], first: usize, second: usize| {
        let by = [0, 1].map(|k| rate[first][k] - rate[second][k]);
        let value = |p: [f64; 2]| by[0] * (p[0] - apex[0]) + by[1] * (p[1] - apex[1]);
        clip(corners, value, on)
    };
    let [first, second, third] = order;
    before(&before(&path.polygon, first, second), second, third)
}

/// Returns the derivatives of the deviation by the errors at the three edges, for light that meets the
/// planes in this order.
fn by_error(cube: &Cube, order: [usize; 3], tangent: f64, index: f64) -> [[f64; 2]; 3] {
    let (_, up, steep) = back([tangent, 0.0], index);
    [0, 1, 2].map(|edge| {
        // The planes that meet at the edge are the other two.
        let turn = |plane: usize| match plane == edge {
            true => [0.0; 3],
            false => cube[3 - edge - plane].map(|x| 0.5 * x),
        };
        let mut light = ([tangent, 0.0, -1.0], [0.0; 3]);
        for plane in order {
            let (normal, turned) = (cube[plane], turn(plane));
            let (d, by) = light;
            let (near, nearer) = (dot(normal, d), dot(turned, d) + dot(normal, by));
            light = (
                [0, 1, 2].map(|k| d[k] - 2.0 * near * normal[k]),
                [0, 1, 2].map(|k| by[k] - 2.0 * (near * turned[k] + nearer * normal[k])),
            );
        }
        // Outside, the part along the sheet is the index times that of the unit vector inside. In the
        // plane of incidence the angle changes by that over the cosine.
        let [across, along, _] = light.1.map(|x| index * x / steep);
        [across / up, along]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sextants of three equal errors at normal incidence are a regular hexagon of spots at 4
    /// sqrt(2/3) times the error and the index, and those of one error two spots at half of it. Each
    /// order of planes has a sixth of the light.
    #[test]
    fn spots_of_a_hexagon_by_hand() {
        let third = f64::sqrt(1.0 / 3.0);
        let edge = |turn: f64| {
            let (sine, cosine) = (turn * PI / 1.5).sin_cos();
            [
                f64::sqrt(2.0 / 3.0) * cosine,
                f64::sqrt(2.0 / 3.0) * sine,
                third,
            ]
        };
        let corner = |k: usize| {
            let (sine, cosine) = (k as f64 * PI / 3.0).sin_cos();
            [cosine, sine]
        };
        let path = Path {
            polygon: (0..6).map(corner).collect(),
            matrix: [[-2.0, 0.0], [0.0, -2.0]],
            offset: [0.0; 2],
            weight: 1.0,
            deviation: [0.0; 2],
            passes: 0,
            jones: None,
            cube: Some([edge(1.0), edge(0.0), edge(2.0)]),
        };
        let direction = Direction {
            incidence_deg: 0.0,
            azimuth_deg: 0.0,
            retroreflected: 1.0,
            probability: ndarray::Array2::zeros((2, 2)),
            range: 2.0,
            standard_error: 0.0,
            interpolated: false,
            paths: Some(vec![path.clone()]),
            exits: None,
        };
        let mut cases = 0;
        for (index, errors, radius) in [
            (1.0, [1e-4; 3], 4.0 * f64::sqrt(2.0 / 3.0)),
            (1.49, [1e-4; 3], 4.0 * f64::sqrt(2.0 / 3.0)),
            (1.0, [1e-4, 0.0, 0.0], 2.0 * f64::sqrt(2.0 / 3.0)),
            (1.49, [0.0, 0.0, 1e-4], 2.0 * f64::sqrt(2.0 / 3.0)),
        ] {
            let bent = direction.bent(errors, index).expect("a cube");
            let paths = bent.paths.expect("paths");
            assert_eq!(paths.len(), 6);
            for path in &paths {
                let [across, along] = path.deviation;
                let found = across.hypot(along) / (1e-4 * index);
                assert!((found - radius).abs() < 1e-12, "{found} {radius}");
                let whole = 1.5 * f64::sqrt(3.0);
                assert!((path.area() - whole / 6.0).abs() < 1e-12);
                cases += 1;
            }
            // Opposite orders leave in opposite directions.
            let sum = paths.iter().fold([0.0; 2], |sum, path| {
                [0, 1].map(|k| sum[k] + path.deviation[k])
            });
            assert!(sum[0].hypot(sum[1]) < 1e-15);
        }
        assert_eq!(cases, 24);
        let cubeless = Direction {
            paths: Some(vec![Path { cube: None, ..path }]),
            ..direction
        };
        assert_eq!(cubeless.bent([1e-4; 3], 1.0), None);
    }
}
