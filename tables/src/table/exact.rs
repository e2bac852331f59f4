//! What an exact bake finds: polygons and the maps of their light.

use crate::table::polygon;

/// One facet sequence of an exact bake: the rays that enter through `polygon` leave shifted by
/// `matrix * p + offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// Corners of the polygon of entry points in the incidence frame (u, v), counter-clockwise,
    /// edge lengths, relative to the apex's perpendicular foot on the entrance plane (of a sheet of
    /// many cubes: to the middle of the corners of the cube's rim).
    pub polygon: Vec<[f64; 2]>,
    /// Linear part of the shift map, row-major [[uu, uv], [vu, vv]].
    pub matrix: [[f64; 2]; 2],
    /// Constant part of the shift map, edge lengths.
    pub offset: [f64; 2],
    /// Share of the launched power that this path returns (1 for lossless reflections); of a sheet
    /// of many cubes, times how often its kind of cube occurs relative to the most frequent kind.
    pub weight: f64,
    /// Where this light goes outside the sheet, as tangents of its angles from straight back:
    /// across the reversed direction of launch within the plane of incidence, towards u, and along
    /// v. At the distance R from the sheet it is off by R times this, whatever the cell's size.
    /// Exactly 0 of exact right angles.
    pub deviation: [f64; 2],
}

impl Path {
    /// Area of the polygon of entry points, square edge lengths.
    pub fn area(&self) -> f64 {
        polygon::area(&self.polygon)
    }

    /// Shift (u, v) of the ray that enters at `entry`, edge lengths.
    pub fn shift(&self, entry: [f64; 2]) -> [f64; 2] {
        let row = |k: usize| {
            let [by_u, by_v] = self.matrix[k];
            by_u * entry[0] + by_v * entry[1] + self.offset[k]
        };
        [row(0), row(1)]
    }
}

/// What `bake --method exact` found: the polygons and maps behind the histogram.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Exact {
    /// Area of the entrance, square edge lengths (of a sheet of many cubes: of one of each kind,
    /// weighted as its paths); eta = sum of weight x polygon area / entrance area.
    pub entrance_area: f64,
    /// Retroreflecting paths of each direction: index = incidence * azimuths + azimuth.
    pub paths: Vec<Vec<Path>>,
}

impl Exact {
    /// The largest angle between light that returns and straight back, rad; 0 of exact right
    /// angles.
    pub fn largest_deviation_rad(&self) -> f64 {
        let all = self.paths.iter().flatten();
        all.map(|path| path.deviation[0].hypot(path.deviation[1]).atan())
            .fold(0.0, f64::max)
    }

    /// Whether the cubes are not exact: light leaves by more than 1e-6 rad, 1 um at a distance of 1
    /// m and ten times what rounding to single precision makes of a mesh, from straight back.
    pub fn deviates(&self) -> bool {
        self.largest_deviation_rad() > 1e-6
    }
}
