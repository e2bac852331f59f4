//! The path of a direction as it is compared and interpolated: its polygon, map, deviation and
//! Jones matrix in the frame of azimuth 0, relative to the fixed point of its map.
//!
//! Deviations and Jones matrices are turned to forms that are nearly affine in tau, the tangent of
//! the incidence inside as a vector.

use num_complex::Complex64;

use crate::table::exact::{Cube, Jones, Path};
use crate::table::polygon::area;

/// Direction of the table near the direction that is asked for.
pub(crate) struct NearDirection {
    /// tan(incidence inside the sheet) (cos azimuth, sin azimuth).
    pub tau: [f64; 2],
    /// Azimuth of the frame of `paths`, radians.
    pub azimuth_rad: f64,
    /// Paths of the direction, in its incidence frame.
    pub paths: Vec<Path>,
    /// Share in a bilinear mixture of the four directions around; 0 for directions further away.
    pub share: f64,
    /// Corner of the gap, if the node is one: 1 for the greater incidence, and for the greater
    /// azimuth.
    pub corner: [f64; 2],
}

/// Shortest edge that has a usable direction, edge lengths.
pub(crate) const SHORT: f64 = 1e-6;

/// Jones matrix between fields along the axes x and y of azimuth 0, seen from above.
pub(crate) type Planar = [[Complex64; 2]; 2];

/// Turns a Jones matrix of the incidence frame at an azimuth to the frame of azimuth 0.
///
/// Near normal incidence s and p turn with the azimuth, and the fields do not: there s lies along v,
/// and p along -u before the sheet and along u behind it. Only after this turn can neighbours be
/// averaged.
fn planar(jones: &Jones, azimuth_rad: f64) -> Planar {
    let [[ss, sp], [ps, pp]] = jones.map(|row| row.map(|[re, im]| Complex64::new(re, im)));
    turned_field([[-pp, ps], [-sp, ss]], azimuth_rad)
}

/// Turns a matrix between fields along u and v to axes that are `angle` behind them.
fn turned_field([[uu, uv], [vu, vv]]: Planar, angle: f64) -> Planar {
    let parts = |part: fn(&Complex64) -> f64| {
        turned_map([[part(&uu), part(&uv)], [part(&vu), part(&vv)]], angle)
    };
    let (re, im) = (parts(|z| z.re), parts(|z| z.im));
    [0, 1].map(|row| [0, 1].map(|column| Complex64::new(re[row][column], im[row][column])))
}

/// Returns the mean of the Jones matrices of a family; `None` if a member has none.
pub(crate) fn mean_field(
    members: &[(&NearDirection, &PathShape)],
    weights: &[f64],
) -> Option<Planar> {
    let mut mean = Planar::default();
    for ((_, shape), weight) in members.iter().zip(weights) {
        let own = shape.jones?;
        for (mean, own) in mean.as_flattened_mut().iter_mut().zip(own.as_flattened()) {
            *mean += own * weight;
        }
    }
    Some(mean)
}

/// Turns a mean back to an azimuth, and gives it the power that a path returns: the mean of phases
/// that differ is too short.
pub(crate) fn scaled(jones: Planar, angle: f64, power: f64) -> Jones {
    let [[uu, uv], [vu, vv]] = turned_field(jones, angle);
    let own: f64 = jones.as_flattened().iter().map(Complex64::norm_sqr).sum();
    let scale = (2.0 * power / own.max(f64::MIN_POSITIVE)).sqrt();
    [[vv, -vu], [uv, -uu]].map(|row| row.map(|z| [scale * z.re, scale * z.im]))
}

/// Returns the direction straight back outside, as its parts along the sheet and up, and 1 /
/// cos(incidence inside).
pub(crate) fn back(tau: [f64; 2], index: f64) -> (f64, f64, f64) {
    let steep = (1.0 + dot(tau, tau)).sqrt();
    let along = index * dot(tau, tau).sqrt() / steep;
    (-along, (1.0 - along * along).max(0.0).sqrt(), steep)
}

/// Converts a deviation ([`Path::deviation`], incidence frame) to numbers that are affine in tau.
pub(crate) fn astray(deviation: [f64; 2], tau: [f64; 2], index: f64) -> [f64; 2] {
    if deviation == [0.0; 2] {
        return deviation;
    }
    let (along, up, steep) = back(tau, index);
    // `bake` defines the deviation as straight back plus tangents across it. Snell's law keeps the
    // part along the sheet times the index.
    let [across, v] = deviation;
    let length = (1.0 + across * across + v * v).sqrt();
    let left = [along + across * up, v].map(|x| x / (length * index));
    [steep * left[0] - along * steep / index, steep * left[1]]
}

/// Converts numbers that are affine in tau to a deviation; the inverse of [`astray`].
pub(crate) fn deviation(astray: [f64; 2], tau: [f64; 2], index: f64) -> [f64; 2] {
    if astray == [0.0; 2] {
        return astray;
    }
    let (along, up, steep) = back(tau, index);
    let [x, y] = [along + index * astray[0] / steep, index * astray[1] / steep];
    let z = (1.0 - x * x - y * y).max(0.0).sqrt();
    let straight = x * along + z * up;
    [(x * up - z * along) / straight, y / straight]
}

/// Turns a vector counter-clockwise by `angle`, radians.
pub(crate) fn turned([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

/// Turns a cube counter-clockwise about the normal of the sheet.
pub(crate) fn turned_cube(cube: Cube, angle: f64) -> Cube {
    cube.map(|[u, v, n]| {
        let [u, v] = turned([u, v], angle);
        [u, v, n]
    })
}

/// Turns a linear map, R M transpose(R): first its columns, then its rows.
pub(crate) fn turned_map([[a, b], [c, d]]: [[f64; 2]; 2], angle: f64) -> [[f64; 2]; 2] {
    let ([a, c], [b, d]) = (turned([a, c], angle), turned([b, d], angle));
    [turned([a, b], angle), turned([c, d], angle)]
}

/// Returns the scalar product.
pub(crate) fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Returns the distance of two points.
pub(crate) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Half-plane normal . p <= offset.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line {
    pub normal: [f64; 2],
    pub offset: f64,
}

/// Path in the frame of azimuth 0, relative to the fixed point of its map.
pub(crate) struct PathShape {
    pub corners: Vec<[f64; 2]>,
    pub(crate) lines: Vec<Line>,
    pub(crate) area: f64,
    /// Fixed point of the map in the frame of azimuth 0, with the origin of the table's polygons.
    pub(crate) fixed: [f64; 2],
    pub matrix: [[f64; 2]; 2],
    pub weight: f64,
    /// Deviation in a form that is affine in tau; 0 for an ideal cube.
    ///
    /// It is the part along the sheet of (M + 1) (tau, -1), where M is the linear map of the path
    /// inside.
    pub astray: [f64; 2],
    pub passes: u32,
    pub(crate) jones: Option<Planar>,
    pub cube: Option<Cube>,
}

impl PathShape {
    /// Makes the shape of a path, or `None` if the polygon is not convex or the map has no fixed
    /// point.
    pub(crate) fn new(path: &Path, node: &NearDirection, index: f64) -> Option<PathShape> {
        let azimuth_rad = node.azimuth_rad;
        let fixed = path.fixed()?;
        let corners: Vec<[f64; 2]> = path
            .polygon
            .iter()
            .map(|p| turned([p[0] - fixed[0], p[1] - fixed[1]], azimuth_rad))
            .collect();
        let ends = corners.iter().zip(corners.iter().cycle().skip(1));
        let lines: Vec<Line> = ends
            .filter(|(a, b)| distance(**a, **b) > SHORT)
            .map(|(a, b)| {
                let length = distance(*a, *b);
                let normal = [(b[1] - a[1]) / length, (a[0] - b[0]) / length];
                Line {
                    normal,
                    offset: dot(normal, [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]),
                }
            })
            .collect();
        let inside = |line: &Line| {
            corners
                .iter()
                .all(|&p| dot(line.normal, p) <= line.offset + SHORT)
        };
        lines.iter().all(inside).then(|| PathShape {
            area: area(&corners),
            fixed: turned(fixed, azimuth_rad),
            lines,
            corners,
            matrix: turned_map(path.matrix, azimuth_rad),
            weight: path.weight,
            astray: turned(astray(path.deviation, node.tau, index), azimuth_rad),
            passes: path.passes,
            jones: path.jones.as_ref().map(|jones| planar(jones, azimuth_rad)),
            cube: path.cube.map(|cube| turned_cube(cube, azimuth_rad)),
        })
    }

    /// Returns the turn of the light about the normal of the sheet, w_z of `TURN` in [`crate::lookup::between`].
    ///
    /// Exit directions near normal incidence do not show it.
    pub(crate) fn about(&self) -> f64 {
        let [[_, b], [c, _]] = self.matrix;
        0.5 * (c - b)
    }

    /// Returns the greatest reach of the polygon along `normal`.
    pub(crate) fn reach(&self, normal: [f64; 2]) -> f64 {
        let along = self.corners.iter().map(|&p| dot(normal, p));
        along.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns the greatest difference of the reaches of two polygons along all their normals.
    pub(crate) fn unlike(&self, other: &PathShape) -> f64 {
        let normals = self
            .lines
            .iter()
            .chain(&other.lines)
            .map(|line| line.normal);
        let apart = normals.map(|normal| (self.reach(normal) - other.reach(normal)).abs());
        apart.fold(0.0, f64::max)
    }
}
