//! A ray-shift table in memory.
//!
//! Frame: shifts are (u, v) in the incidence frame of the entrance plane, u along the in-plane travel
//! direction, v = n x u, in edge lengths. Array axes are `[incidence, azimuth, shift_v, shift_u]`.

use ndarray::{Array2, Array3, Array4, Array5, Axis};

use crate::deviation::Deviations;
use crate::provenance::Provenance;

/// What became of a ray. The names and their order are those of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(usize)]
pub enum Fate {
    /// Came back by a path whose linear map is -I, shift inside the histogram.
    Retroreflected,
    /// Left the cell after one reflection.
    LeftAfter1,
    /// Left the cell after two reflections.
    LeftAfter2,
    /// Left antiparallel by a path whose linear map is not -I.
    AntiparallelOther,
    /// Left in another direction after three reflections or more.
    Deviated,
    /// Went through a facet where total internal reflection failed.
    Transmitted,
    /// Absorbed by a facet, met one from behind, or was reflected by the front face on the way in or out.
    Absorbed,
    /// Hit nothing.
    Missed,
    /// Retroreflected, but the shift lies outside the histogram.
    OutOfRange,
    /// Was stopped after the greatest number of reflections.
    BounceLimit,
}

impl Fate {
    /// All fates, in the order of the file.
    pub const ALL: [Fate; 10] = [
        Fate::Retroreflected,
        Fate::LeftAfter1,
        Fate::LeftAfter2,
        Fate::AntiparallelOther,
        Fate::Deviated,
        Fate::Transmitted,
        Fate::Absorbed,
        Fate::Missed,
        Fate::OutOfRange,
        Fate::BounceLimit,
    ];

    /// The name in the file.
    pub const fn name(self) -> &'static str {
        match self {
            Fate::Retroreflected => "retroreflected",
            Fate::LeftAfter1 => "left_after_1",
            Fate::LeftAfter2 => "left_after_2",
            Fate::AntiparallelOther => "antiparallel_other",
            Fate::Deviated => "deviated",
            Fate::Transmitted => "transmitted",
            Fate::Absorbed => "absorbed",
            Fate::Missed => "missed",
            Fate::OutOfRange => "out_of_range",
            Fate::BounceLimit => "bounce_limit",
        }
    }
}

/// The directions and bins of a table.
///
/// Two axes are equal when every value is; the NaN azimuth of a mean table equals itself.
#[derive(Debug, Clone)]
pub struct Axes {
    /// Incidence angles outside the sheet, degrees, ascending, 0 <= theta < 90.
    pub incidence_deg: Vec<f64>,
    /// Azimuths, degrees, ascending; the single value NaN for a mean over all azimuths.
    pub azimuth_deg: Vec<f64>,
    /// Bins along each of u and v.
    pub bins: usize,
    /// The histogram covers u, v in [-range, range], edge lengths.
    pub range: f64,
}

impl PartialEq for Axes {
    fn eq(&self, other: &Self) -> bool {
        let same = |a: &[f64], b: &[f64]| {
            a.len() == b.len()
                && a.iter()
                    .zip(b)
                    .all(|(a, b)| a == b || (a.is_nan() && b.is_nan()))
        };
        same(&self.incidence_deg, &other.incidence_deg)
            && same(&self.azimuth_deg, &other.azimuth_deg)
            && self.bins == other.bins
            && self.range == other.range
    }
}

impl Axes {
    /// Whether the table holds the mean over all azimuths instead of single ones.
    pub fn is_mean(&self) -> bool {
        matches!(self.azimuth_deg[..], [azimuth] if azimuth.is_nan())
    }

    /// Bin width, edge lengths.
    pub fn bin_width(&self) -> f64 {
        2.0 * self.range / self.bins as f64
    }

    /// Centre of bin `i`, edge lengths.
    pub fn bin_centre(&self, i: usize) -> f64 {
        (i as f64 + 0.5) * self.bin_width() - self.range
    }

    /// (directions along incidence, directions along azimuth).
    pub fn shape(&self) -> (usize, usize) {
        (self.incidence_deg.len(), self.azimuth_deg.len())
    }

    /// All directions (incidence, azimuth), degrees, in the order of the arrays: incidence slow, azimuth fast.
    pub fn directions(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let azimuths = move |&i| self.azimuth_deg.iter().map(move |&a| (i, a));
        self.incidence_deg.iter().flat_map(azimuths)
    }
}

/// One facet sequence of an exact bake: the rays that enter through `polygon` leave shifted by `matrix * p +
/// offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// Corners of the polygon of entry points in the incidence frame (u, v), counter-clockwise, edge lengths,
    /// relative to the apex's perpendicular foot on the entrance plane (of a sheet of many cubes: to the middle of the
    /// corners of the cube's rim).
    pub polygon: Vec<[f64; 2]>,
    /// Linear part of the shift map, row-major [[uu, uv], [vu, vv]].
    pub matrix: [[f64; 2]; 2],
    /// Constant part of the shift map, edge lengths.
    pub offset: [f64; 2],
    /// Share of the launched power that this path returns (1 for lossless reflections); of a sheet of many cubes, times
    /// how often its kind of cube occurs relative to the most frequent kind.
    pub weight: f64,
    /// Where this light goes outside the sheet, as tangents of its angles from straight back: across the reversed direction of
    /// launch within the plane of incidence, towards u, and along v. At the distance R from the sheet it is off by R times
    /// this, whatever the cell's size. Exactly 0 of exact right angles.
    pub deviation: [f64; 2],
}

impl Path {
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
    /// Area of the entrance, square edge lengths (of a sheet of many cubes: of one of each kind, weighted as its paths);
    /// eta = sum of weight x polygon area / entrance area.
    pub entrance_area: f64,
    /// Retroreflecting paths of each direction: index = incidence * azimuths + azimuth.
    pub paths: Vec<Vec<Path>>,
}

impl Exact {
    /// The largest angle between light that returns and straight back, rad; 0 of exact right angles.
    pub fn largest_deviation_rad(&self) -> f64 {
        let all = self.paths.iter().flatten();
        all.map(|path| path.deviation[0].hypot(path.deviation[1]).atan())
            .fold(0.0, f64::max)
    }

    /// Whether the cubes are not exact: light leaves by more than 1e-6 rad, 1 um at a distance of 1 m and ten times what
    /// rounding to single precision makes of a mesh, from straight back.
    pub fn deviates(&self) -> bool {
        self.largest_deviation_rad() > 1e-6
    }
}

/// A ray-shift table.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Directions and bins.
    pub axes: Axes,
    /// Conditional probability `[incidence, azimuth, v, u]`: sums to 1 per direction, or all 0 where nothing
    /// returns.
    pub histogram: Array4<f64>,
    /// Rays per bin `[incidence, azimuth, randomisation, v, u]`; `None` for an exact table.
    pub counts: Option<Array5<u64>>,
    /// Retroreflected fraction eta `[incidence, azimuth]` (out_of_range counts as retroreflected).
    pub retroreflected: Array2<f64>,
    /// Standard error of `retroreflected`; 0 for an exact table.
    pub standard_error: Array2<f64>,
    /// Fraction of the launched rays by fate `[incidence, azimuth, fate]`, in the order of [`Fate::ALL`]; sums
    /// to 1.
    pub fate: Array3<f64>,
    /// Rays by fate `[incidence, azimuth, randomisation, fate]`; `None` for an exact table.
    pub fate_counts: Option<Array4<u64>>,
    /// Rays launched `[incidence, azimuth]`; 0 for an exact table.
    pub rays: Array2<u64>,
    /// Polygons and maps of an exact table.
    pub exact: Option<Exact>,
    /// Rays by shift and by the direction that they leave in, where the cell is not ideal; `None` of an exact table.
    pub deviations: Option<Deviations>,
    /// Where it comes from.
    pub provenance: Provenance,
}

impl Table {
    /// The table of some of its directions, named by their indices: that of a bake of them alone.
    ///
    /// # Panics
    /// An index that is out of range.
    pub fn part(&self, incidences: &[usize], azimuths: &[usize]) -> Table {
        let pick = |angles: &[f64], which: &[usize]| which.iter().map(|&k| angles[k]).collect();
        let columns = self.axes.azimuth_deg.len();
        let row = |i: &usize| -> Vec<usize> { azimuths.iter().map(|j| i * columns + j).collect() };
        let places: Vec<usize> = incidences.iter().flat_map(row).collect();
        macro_rules! part {
            ($array:expr) => {
                $array.select(Axis(0), incidences).select(Axis(1), azimuths)
            };
        }
        Table {
            axes: Axes {
                incidence_deg: pick(&self.axes.incidence_deg, incidences),
                azimuth_deg: pick(&self.axes.azimuth_deg, azimuths),
                ..self.axes.clone()
            },
            histogram: part!(self.histogram),
            counts: self.counts.as_ref().map(|counts| part!(counts)),
            retroreflected: part!(self.retroreflected),
            standard_error: part!(self.standard_error),
            fate: part!(self.fate),
            fate_counts: self.fate_counts.as_ref().map(|fates| part!(fates)),
            rays: part!(self.rays),
            exact: self.exact.as_ref().map(|exact| Exact {
                entrance_area: exact.entrance_area,
                paths: places.iter().map(|&k| exact.paths[k].clone()).collect(),
            }),
            deviations: self.deviations.as_ref().map(|found| Deviations {
                grid: found.grid,
                entries: places.iter().map(|&k| found.entries[k].clone()).collect(),
            }),
            provenance: self.provenance.clone(),
        }
    }
}
