//! Ray-shift table in memory.
//!
//! Frame: shifts are (u, v) in the incidence frame of the entrance plane, in edge lengths. u points
//! along the in-plane travel direction, and v = n x u. Array axes are `[incidence, azimuth,
//! shift_v, shift_u]`.

use ndarray::{Array2, Array3, Array4, Array5, Axis};

use crate::lookup::passage::Passage;
use crate::table::axes::Axes;
use crate::table::exact::Exact;

use crate::table::deviation::Deviations;
use crate::table::fate::Fate;
use crate::table::provenance::Provenance;

/// Ray-shift table.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Directions and bins.
    pub axes: Axes,
    /// Conditional probability `[incidence, azimuth, v, u]`: sums to 1 per direction, or all 0
    /// where nothing returns.
    pub histogram: Array4<f64>,
    /// Rays per bin `[incidence, azimuth, randomisation, v, u]`; `None` for an exact table.
    pub counts: Option<Array5<u64>>,
    /// Retroreflected share eta `[incidence, azimuth]`; out_of_range counts as retroreflected.
    pub retroreflected: Array2<f64>,
    /// Standard error of `retroreflected`; 0 for an exact table.
    pub standard_error: Array2<f64>,
    /// Share of the launched rays by fate `[incidence, azimuth, fate]`, in the order of
    /// [`Table::fates`]; sums to 1.
    pub fate: Array3<f64>,
    /// Rays by fate `[incidence, azimuth, randomisation, fate]`; `None` for an exact table.
    pub fate_counts: Option<Array4<u64>>,
    /// Rays launched `[incidence, azimuth]`; 0 for an exact table.
    pub rays: Array2<u64>,
    /// Polygons and maps of an exact table.
    pub exact: Option<Exact>,
    /// Rays by shift and deviation, where the cell is not ideal; `None` for an exact table.
    pub deviations: Option<Deviations>,
    /// Origin of the table.
    pub provenance: Provenance,
    /// What light passes before and behind the sheet, which [`Table::direction`] takes into account;
    /// no part of the file.
    pub passage: Option<Passage>,
    /// Dihedral errors of all cubes beside those of the table, rad, which [`Table::direction`] takes into
    /// account; no part of the file.
    pub errors_rad: [f64; 3],
}

impl Table {
    /// Returns the fates of the light, in the order of the file.
    pub fn fates(&self) -> &'static [Fate] {
        self.provenance.fates(self.fate.dim().2)
    }

    /// Returns the table of some of its directions, named by their indices.
    ///
    /// It equals a bake of these directions alone.
    ///
    /// # Panics
    /// Panics if an index is out of range.
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
            passage: self.passage,
            errors_rad: self.errors_rad,
            provenance: self.provenance.clone(),
        }
    }
}
