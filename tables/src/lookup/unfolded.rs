//! A table at other azimuths, for which its own stand by symmetry.

use ndarray::s;

use crate::lookup::direction::turn;
use crate::table::symmetry::{Symmetry, mirrored_paths};
use crate::table::table::Table;

/// Greatest difference of two azimuths that count as equal, degrees: mirror planes are found from
/// coordinates that may have been rounded.
const SAME_DEG: f64 = 1e-6;

impl Table {
    /// Returns the table at other azimuths, degrees, for which its own stand by symmetry.
    ///
    /// Nothing is interpolated. The table that is returned has no symmetry. It is `None` if one of
    /// the azimuths is neither an azimuth of the table nor an image of one to 1e-6 degrees, or if the
    /// table is a mean over azimuths. So it is if a mirrored direction has exit directions of rays.
    pub fn unfolded(&self, azimuth_deg: &[f64]) -> Option<Table> {
        if self.axes.is_mean() {
            return None;
        }
        let known = self.azimuths();
        let image = |&azimuth: &f64| {
            let same = |(at, ..): &&(f64, usize, bool)| turn(at - azimuth).abs() <= SAME_DEG;
            known
                .iter()
                .find(same)
                .map(|&(_, place, mirrored)| (place, mirrored))
        };
        let images = azimuth_deg.iter().map(image).collect::<Option<Vec<_>>>()?;
        let mirrored = || (0..images.len()).filter(|&k| images[k].1);
        if self.deviations.is_some() && mirrored().next().is_some() {
            return None;
        }
        let incidences: Vec<usize> = (0..self.axes.incidence_deg.len()).collect();
        let places: Vec<usize> = images.iter().map(|(place, _)| *place).collect();
        let mut table = self.part(&incidences, &places);
        for k in mirrored() {
            let turned = table.histogram.slice(s![.., k, ..;-1, ..]).to_owned();
            table.histogram.slice_mut(s![.., k, .., ..]).assign(&turned);
            if let Some(counts) = &mut table.counts {
                let turned = counts.slice(s![.., k, .., ..;-1, ..]).to_owned();
                counts.slice_mut(s![.., k, .., .., ..]).assign(&turned);
            }
            for paths in table.exact.iter_mut().flat_map(|exact| {
                let own = exact.paths.iter_mut();
                own.skip(k).step_by(images.len())
            }) {
                *paths = mirrored_paths(paths);
            }
        }
        table.axes.azimuth_deg = azimuth_deg.to_vec();
        table.provenance.symmetry = Symmetry::NONE;
        Some(table)
    }
}
