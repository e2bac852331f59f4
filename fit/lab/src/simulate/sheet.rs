//! Sheets that a table describes, in the place of the ideal cube. The shift of each polygon
//! includes the deviation of its light at the distance of each capture.

use tables::Table;

use crate::simulate::cell::CubeShift;
use crate::simulate::error::Error;
use crate::simulate::params::{Params, PlantedShot};

impl Params {
    /// Replaces the ideal cubes of a campaign by the sheet that `table` describes.
    /// `refractive_index` and `pair` of its truth then have no effect.
    ///
    /// # Errors
    /// Returns `Error::Sheet` if the table has no polygons for the direction of a capture, if no
    /// light returns there, or if the kernel is `wave`.
    pub fn of_sheet(mut self, table: &Table) -> Result<Params, Error> {
        let refused = |why: String| Err(Error::Sheet { why });
        if self.truth.kernel.has_waves() {
            return refused(
                "waves can only be simulated for ideal cubes; leave --table out".into(),
            );
        }
        let c_mm = self.truth.c_mm;
        for shot in &mut self.captures {
            let PlantedShot {
                incidence_deg,
                azimuth_deg,
                ..
            } = *shot;
            let direction = match table.direction(incidence_deg, Some(azimuth_deg)) {
                Ok(direction) => direction,
                Err(error) => return refused(error.to_string()),
            };
            let r_mm = shot.path_mm.unwrap_or(shot.floating_distance_mm);
            let cosine = incidence_deg.to_radians().cos();
            let eta = direction.retroreflected;
            let moved = match direction.seen_from(r_mm, c_mm, cosine) {
                Ok(moved) => moved,
                Err(error) => return refused(error.to_string()),
            };
            let Some(paths) = moved.paths.filter(|_| eta > 0.0) else {
                return refused(format!(
                    "it has no polygons of returned light at incidence {incidence_deg} deg, \
                    azimuth {azimuth_deg} deg; bake this direction with --method exact, or leave \
                    it out"
                ));
            };
            let powers = || paths.iter().map(|path| path.weight * path.area());
            let total: f64 = powers().sum();
            let shifts = paths.iter().zip(powers()).map(|(path, power)| CubeShift {
                polygon: path.polygon.iter().map(|&p| path.shift(p)).collect(),
                retroreflected: eta * power / total,
            });
            shot.shifts = Some(shifts.collect());
        }
        Ok(self)
    }
}
