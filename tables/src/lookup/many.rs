//! The returned share at many directions, without the histograms and paths of each.

use crate::error::Error;
use crate::lookup::family::Family;
use crate::lookup::grid_cell::Bracket;
use crate::table::table::Table;

/// Gap in which the last direction lay, and its paths; `None` if they cannot be interpolated.
type Gap = ([usize; 4], Option<Vec<Family>>);

impl Table {
    /// Returns eta at directions (incidence, azimuth), degrees: that of [`Table::direction`].
    ///
    /// It is hundreds of times faster if neighbours in the list lie in one gap of the table.
    ///
    /// # Errors
    /// Returns the error of the first direction that has one.
    pub fn retroreflected_at(&self, directions: &[[f64; 2]]) -> Result<Vec<f64>, Error> {
        let images = self.images();
        // Paths between polarisers have other weights than their families.
        let is_plain = !self.axes.is_mean() && self.passage.is_none();
        let exact = self.exact.as_ref().filter(|_| is_plain);
        let mut gap: Option<Gap> = None;
        let mut eta = |&[incidence_deg, azimuth_deg]: &[f64; 2]| {
            let slowly = || {
                let found = self.direction(incidence_deg, Some(azimuth_deg))?;
                Ok(found.retroreflected)
            };
            let cell = self.cell(&images, incidence_deg, azimuth_deg);
            let (Some(exact), Some(cell)) = (exact, cell) else {
                return slowly();
            };
            let (along, across) = (cell.along, cell.across);
            if along.2 == 0.0 && across.2 == 0.0 {
                return slowly();
            }
            let key = [along.0, along.1, across.0, across.1];
            if gap.as_ref().is_none_or(|(known, _)| *known != key) {
                // It refuses polygons that are too many.
                slowly()?;
                gap = Some((key, self.families(incidence_deg, azimuth_deg)));
            }
            let Some((_, Some(families))) = &gap else {
                return slowly();
            };
            let tau = cell.tau(incidence_deg, azimuth_deg.to_radians());
            let share = |[far, beyond]: [f64; 2]| end(along, far) * end(across, beyond);
            let light = families.iter().map(|family| family.light(tau, share));
            Ok((light.sum::<f64>() / exact.entrance_area).min(1.0))
        };
        directions.iter().map(&mut eta).collect()
    }
}

/// Returns the share of one end of a bracket: the far end, 1, or the near one, 0.
fn end((first, second, share): Bracket, far: f64) -> f64 {
    match (first == second, far > 0.5) {
        (true, _) => 1.0,
        (false, true) => share,
        (false, false) => 1.0 - share,
    }
}
