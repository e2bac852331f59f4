//! Polygons of an exact bake and the maps of their light.

use crate::table::polygon;

/// One facet sequence of an exact bake: a polygon of entry points and the map of their shifts.
///
/// A ray that enters at the point p of `polygon` leaves shifted by `matrix * p + offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// Corners of the polygon of entry points in the incidence frame (u, v), counter-clockwise,
    /// edge lengths.
    ///
    /// The origin is the foot of the perpendicular from the apex on the entrance plane. In a sheet
    /// of many cubes it is the middle of the corners of the cube's rim.
    pub polygon: Vec<[f64; 2]>,
    /// Linear part of the shift map, row-major [[uu, uv], [vu, vv]].
    pub matrix: [[f64; 2]; 2],
    /// Constant part of the shift map, edge lengths.
    pub offset: [f64; 2],
    /// Share of the launched power that this path returns; 1 for lossless reflections.
    ///
    /// In a sheet of many cubes it is multiplied by the frequency of this kind of cube relative to
    /// the most frequent kind.
    pub weight: f64,
    /// Deviation outside the sheet, as tangents of the angles from straight back.
    ///
    /// The first component lies in the plane of incidence, across the reversed direction of launch,
    /// towards u. The second lies along v. At the distance R from the sheet the light is off by R
    /// times these tangents, whatever the size of the cell. Both are exactly 0 for exact right
    /// angles.
    pub deviation: [f64; 2],
    /// Number of times that the front face sent the light back inside.
    pub passes: u32,
    /// Amplitudes of polarised light; `None` for ideal mirrors, which keep the field, and in tables
    /// from before version 0.2.
    pub jones: Option<Jones>,
    /// The cube that returns the light; `None` if it is no corner of three planes, and in tables from
    /// before 28 November 2026.
    pub cube: Option<Cube>,
}

/// Unit normals of the three planes of a cube, towards the light, each as (u, v, n) with n out of the
/// sheet. They come in any order. Of a cube without errors they are the directions of its edges, away
/// from the apex.
pub type Cube = [[f64; 3]; 3];

/// Jones matrix of a path outside the sheet, row-major [[ss, sp], [ps, pp]], each as (real,
/// imaginary).
///
/// An electric field (s, p) at the entry leaves as the matrix times (s, p). s is along v, and p = s
/// x the direction of travel, for the light that arrives and for the light that leaves.
pub type Jones = [[[f64; 2]; 2]; 2];

impl Path {
    /// Returns the area of the polygon of entry points, square edge lengths.
    pub fn area(&self) -> f64 {
        polygon::area(&self.polygon)
    }

    /// Returns the shift (u, v) of the ray that enters at `entry`, edge lengths.
    pub fn shift(&self, entry: [f64; 2]) -> [f64; 2] {
        let row = |k: usize| {
            let [by_u, by_v] = self.matrix[k];
            by_u * entry[0] + by_v * entry[1] + self.offset[k]
        };
        [row(0), row(1)]
    }

    /// Returns the point of entry that is not shifted, above the apex of an ideal cube; `None` if the map
    /// is nearly singular.
    pub(crate) fn fixed(&self) -> Option<[f64; 2]> {
        let ([[a, b], [c, d]], [u, v]) = (self.matrix, self.offset);
        let determinant = a * d - b * c;
        let fixed = [(b * v - d * u) / determinant, (c * u - a * v) / determinant];
        (determinant.abs() >= 1e-3).then_some(fixed)
    }
}

/// Polygons and maps that `bake --method exact` found; the histogram follows from them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Exact {
    /// Area of the entrance, square edge lengths.
    ///
    /// eta = sum of weight x polygon area / entrance area. For a sheet of many cubes it is the sum
    /// of one entrance of each kind, weighted as the paths are.
    pub entrance_area: f64,
    /// Retroreflecting paths of each direction; index = incidence * azimuths + azimuth.
    pub paths: Vec<Vec<Path>>,
}

impl Exact {
    /// Returns the largest angle between returned light and straight back, rad; 0 for exact right
    /// angles.
    pub fn largest_deviation_rad(&self) -> f64 {
        let all = self.paths.iter().flatten();
        all.map(|path| path.deviation[0].hypot(path.deviation[1]).atan())
            .fold(0.0, f64::max)
    }

    /// Returns whether light leaves by more than 1e-6 rad from straight back.
    ///
    /// 1e-6 rad is 1 um at a distance of 1 m. It is ten times the deviation that rounding a mesh to
    /// single precision causes.
    pub fn deviates(&self) -> bool {
        self.largest_deviation_rad() > 1e-6
    }
}
