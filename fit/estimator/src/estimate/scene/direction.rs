//! The table's direction for a photograph, projected on the photograph's edge normal.

use std::sync::{Arc, OnceLock};

use tables::Direction;

use crate::model::baseline;
use crate::model::wave;
use edges::names::Kernel;
use edges::names::Spectrum;
use tables::ShiftLine;
use tables::WaveLine;

/// Retroreflected share of the light, with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Returned {
    /// Retroreflected share, from 0 to 1.
    pub retroreflected: f64,
    /// Standard deviation that the number of the table's rays causes.
    pub standard_error: f64,
}

impl Returned {
    /// Returns the standard error divided by the share.
    pub fn relative_error(&self) -> f64 {
        self.standard_error / self.retroreflected
    }
}

/// Direction of the table for one photograph at one azimuth of the sheet.
#[derive(Debug, Clone)]
pub struct ProjectedDirection {
    /// Azimuth, degrees; `None` if the table is a mean over azimuths and needs none.
    pub azimuth_deg: Option<f64>,
    /// Retroreflected share of the table.
    pub returned: Returned,
    /// Incidence outside the sheet, radians.
    incidence_rad: f64,
    /// Refractive index behind the sheet's front face; 1 for hollow cubes.
    pub refractive_index: f64,
    /// Shift along the edge normal.
    pub shift: Option<ShiftLine>,
    /// The same for cubes with dihedral errors, made when a fit first asks for it.
    bent: OnceLock<Option<ShiftLine>>,
    /// The direction itself, without its bins.
    direction: Arc<Direction>,
    /// Edge normal in the mid-air image, (tangential, sagittal).
    normal: [f64; 2],
    /// Waves along the edge normal, or the reason why there are none.
    pub wave: Result<WaveLine, wave::Fault>,
}

/// Position of a photograph's edge relative to the sheet, apart from the azimuth.
#[derive(Debug, Clone, Copy)]
pub struct Along<'a> {
    /// Incidence outside the sheet, radians.
    pub incidence_rad: f64,
    /// Edge normal in the mid-air image, (tangential, sagittal).
    pub normal: [f64; 2],
    /// Wavelengths of the source.
    pub spectrum: Option<&'a Spectrum>,
}

impl ProjectedDirection {
    /// Projects a direction that returns light on the edge normal.
    pub fn new(
        direction: &Direction,
        azimuth_deg: Option<f64>,
        refractive_index: f64,
        seen: Along,
    ) -> ProjectedDirection {
        let Along {
            incidence_rad,
            normal,
            spectrum,
        } = seen;
        ProjectedDirection {
            azimuth_deg,
            returned: Returned {
                retroreflected: direction.retroreflected,
                standard_error: direction.standard_error,
            },
            incidence_rad,
            refractive_index,
            shift: ShiftLine::new(direction, incidence_rad, normal),
            bent: OnceLock::new(),
            direction: Arc::new(direction.without_bins()),
            normal,
            wave: wave::line(direction, incidence_rad, normal, spectrum),
        }
    }

    /// Returns the shift of cubes with dihedral errors along the edge normal; `None` if the table does
    /// not say which cubes its paths belong to.
    pub fn bent(&self) -> Option<&ShiftLine> {
        let line = || {
            let (theta, index) = (self.incidence_rad, self.refractive_index);
            ShiftLine::with_errors(&self.direction, theta, self.normal, index)
        };
        self.bent.get_or_init(line).as_ref()
    }

    /// Returns the projection of a direction without light. The lines have no meaning there
    /// and are kept.
    pub fn dark(&self, direction: &Direction, azimuth_deg: Option<f64>) -> ProjectedDirection {
        ProjectedDirection {
            azimuth_deg,
            returned: Returned {
                retroreflected: direction.retroreflected,
                standard_error: direction.standard_error,
            },
            ..self.clone()
        }
    }

    /// Returns the share of the light that the sheet returns before mu, as a kernel counts it. The
    /// baselines with a front subtract the reflections of the front.
    pub fn returned_as(&self, kernel: Kernel) -> Returned {
        let Returned {
            retroreflected: eta,
            standard_error,
        } = self.returned;
        if !kernel.is_baseline() {
            return self.returned;
        }
        let of = |eta| baseline::returned(kernel, eta, self.incidence_rad, self.refractive_index);
        Returned {
            retroreflected: of(eta),
            standard_error: of(eta + standard_error) - of(eta),
        }
    }
}
