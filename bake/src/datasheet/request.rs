//! Conditions of a data sheet, and their checks.

use crate::error::Error;
use num_complex::Complex64;

/// Largest number of random cells.
pub(crate) const MOST_CELLS: u32 = 200;

/// Conditions of a data sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct DatasheetRequest {
    /// Refractive index behind the front face; `None` stands for the file's, else 1.
    pub refractive_index: Option<f64>,
    /// Name of the metal, for titles.
    pub metal: String,
    /// Complex refractive index n + ik of the metal.
    pub metal_index: Complex64,
    /// Wavelength in vacuum, nm, of the diffraction and of the material of the file.
    pub wavelength_nm: f64,
    /// Step of the incidences and of the azimuths of the map, degrees, from 1 to 15.
    pub step_deg: f64,
    /// Largest incidence of the map, degrees, from 10 to 85.
    pub up_to_deg: f64,
    /// Incidences of spots and tolerances, degrees, at most four.
    pub incidence_deg: Vec<f64>,
    /// Azimuth of spots and tolerances, degrees.
    pub azimuth_deg: f64,
    /// Distance from the sheet to the image, mm.
    pub distance_mm: f64,
    /// Standard deviation of the dihedral errors of random cells, mrad.
    pub error_mrad: f64,
    /// Number of random cells, from 2 to 200.
    pub cells: u32,
    /// Seed of the random cells.
    pub seed: u64,
    /// Largest deviation of retroreflected light, degrees.
    pub angular_tolerance_deg: f64,
}

impl DatasheetRequest {
    /// Checks that every number is in its range.
    ///
    /// # Errors
    /// Returns [`Error::Usage`], which names the option and its range.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let usage = |option: &str, value: f64, range: &str| {
            Err(Error::Usage(format!("{option} {value}: give {range}")))
        };
        let index = self.refractive_index.unwrap_or(1.0);
        if !(1.0..=10.0).contains(&index) {
            return usage("--refractive-index", index, "a number from 1 to 10");
        }
        let numbers = [
            ("--wavelength-nm", self.wavelength_nm, 1.0, 1e6, "nm"),
            ("--step", self.step_deg, 1.0, 15.0, "degrees"),
            ("--up-to", self.up_to_deg, 10.0, 85.0, "degrees"),
            ("--azimuth", self.azimuth_deg, -360.0, 360.0, "degrees"),
            ("--distance", self.distance_mm, 1.0, 1e6, "mm"),
            ("--error-mrad", self.error_mrad, 0.001, 5.0, "mrad"),
        ];
        for (option, value, least, most, unit) in numbers {
            if !(least..=most).contains(&value) {
                return usage(option, value, &format!("{least} to {most} {unit}"));
            }
        }
        if !(2..=MOST_CELLS).contains(&self.cells) {
            let range = format!("a number of cells from 2 to {MOST_CELLS}");
            return usage("--cells", f64::from(self.cells), &range);
        }
        let count = self.incidence_deg.len();
        if !(1..=4).contains(&count) {
            let range = "one to four angles, such as 0,30";
            return Err(Error::Usage(format!(
                "--incidence names {count} angles: give {range}"
            )));
        }
        let beyond = |deg: &&f64| !(0.0..=85.0).contains(*deg);
        match self.incidence_deg.iter().find(beyond) {
            Some(&deg) => usage("--incidence", deg, "angles from 0 to 85 degrees"),
            None => Ok(()),
        }
    }
}
