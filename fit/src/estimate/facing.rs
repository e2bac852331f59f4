//! How a photograph faces the sheet: the table's direction, along the photograph's edge normal.

use tables::Direction;

use crate::model::baseline;
use crate::model::wave;
use crate::names::Kernel;
use crate::names::Spectrum;
use tables::ShiftLine;
use tables::WaveLine;

/// The retroreflected share of the light, and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Returned {
    /// The share.
    pub eta: f64,
    /// One standard deviation, by the table's rays.
    pub standard_error: f64,
}

impl Returned {
    /// Standard error over the share.
    pub fn relative_error(&self) -> f64 {
        self.standard_error / self.eta
    }
}

/// What the table says of one photograph at one azimuth of the sheet.
#[derive(Debug, Clone)]
pub struct Facing {
    /// Azimuth, degrees; `None` where a table of the mean over azimuths needs none.
    pub azimuth_deg: Option<f64>,
    /// Retroreflected share by the table.
    pub returned: Returned,
    /// Incidence, outside, radians.
    incidence_rad: f64,
    /// Of the sheet's front face; 1 for hollow cubes.
    pub refractive_index: f64,
    /// Shift along the edge normal.
    pub shift: Option<ShiftLine>,
    /// Waves along the edge normal, where the campaign names wavelengths and the table allows.
    pub wave: Result<WaveLine, wave::Fault>,
}

/// Where a photograph's edge lies to the sheet, whatever the azimuth.
#[derive(Debug, Clone, Copy)]
pub struct Along<'a> {
    /// Incidence, outside, radians.
    pub incidence_rad: f64,
    /// Edge normal in the aerial image, (tangential, sagittal).
    pub normal: [f64; 2],
    /// Wavelengths of the source.
    pub spectrum: Option<&'a Spectrum>,
}

impl Facing {
    /// Projects a direction that returns light on the edge normal.
    pub fn new(
        direction: &Direction,
        azimuth_deg: Option<f64>,
        refractive_index: f64,
        seen: Along,
    ) -> Facing {
        let Along {
            incidence_rad,
            normal,
            spectrum,
        } = seen;
        Facing {
            azimuth_deg,
            returned: Returned {
                eta: direction.eta,
                standard_error: direction.standard_error,
            },
            incidence_rad,
            refractive_index,
            shift: ShiftLine::new(direction, incidence_rad, normal),
            wave: wave::line(direction, incidence_rad, normal, spectrum),
        }
    }

    /// The same at an azimuth from which nothing comes back: its lines mean nothing there, and
    /// stay.
    pub fn dark(&self, direction: &Direction, azimuth_deg: f64) -> Facing {
        Facing {
            azimuth_deg: Some(azimuth_deg),
            returned: Returned {
                eta: direction.eta,
                standard_error: direction.standard_error,
            },
            ..self.clone()
        }
    }

    /// The share of the light that the sheet returns before mu, as a kernel has it: a baseline
    /// takes the front's reflections off.
    pub fn returned_as(&self, kernel: Kernel) -> Returned {
        let Returned {
            eta,
            standard_error,
        } = self.returned;
        if !kernel.is_baseline() {
            return self.returned;
        }
        let of = |eta| baseline::returned(kernel, eta, self.incidence_rad, self.refractive_index);
        Returned {
            eta: of(eta),
            standard_error: of(eta + standard_error) - of(eta),
        }
    }
}
