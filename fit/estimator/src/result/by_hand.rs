//! A sheet whose numbers are given by hand, for who has no fit of it.

use crate::estimate::{Bounds, Forward, Kind};
use crate::result::capture::CameraResult;
use crate::result::parameter::Covariance;
use crate::result::parameter::{Number, Parameter};
use crate::result::report::ResultFile;
use crate::result::table::TableResult;
use edges::names::{Family, Kernel, LobeShape, Spectrum, Stray};

/// Reason why the solver of such a result stopped: it never began.
const BY_HAND: &str = "given by hand";

/// Reason why the solver of a result of a nominal sheet stopped.
pub(super) const NOMINAL: &str = "taken from a nominal sheet";

/// Cause that spreads the light besides the ray shift.
#[derive(Debug, Clone, PartialEq)]
pub enum Spread {
    /// Diffraction by wave optics, from c and these wavelengths.
    Wave(Spectrum),
    /// Lobe of this spread a, 1/mm, at every distance.
    Lobe(f64),
    /// Lobe of a fixed angle, of this A = a R.
    Angle(f64),
}

/// Numbers of a sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct ByHand {
    /// Corner size c, mm.
    pub c_mm: f64,
    /// Cause that spreads the light.
    pub spread: Spread,
    /// Standard deviation of the direction of the returned light across the plane of incidence,
    /// mrad; `None` for a sheet without angular errors.
    pub angular_spread_mrad: Option<f64>,
    /// Reflectance mu; `None` if it is not known.
    pub mu: Option<f64>,
    /// Transmittance times reflectance of the half mirror.
    pub half_mirror: f64,
    /// Side of a pixel in the plane of the mid-air image, mm.
    pub pixel_pitch_mm: f64,
}

/// Warning about a lobe that is the same at all distances.
const ONE_LOBE: &str = "a is taken as the same at every distance (kernel eq1); a lobe that grows \
    with the distance is --a-times-r (fixed angle) or --wavelength-nm (wave optics), and which of \
    them a sheet has is told by photographs at two distances";

/// Corner size, mm, above which it is asked whether micrometres were meant. Sheets have corners of
/// some hundredths of a mm to 1 mm, cast road reflectors up to 5 mm.
const LARGE_MM: f64 = 10.0;

impl ByHand {
    /// Returns warnings about the numbers.
    fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.c_mm > LARGE_MM {
            let (c, less) = (self.c_mm, self.c_mm / 1000.0);
            warnings.push(format!(
                "corners of {c} mm are far larger than those of sheets; --c is in mm, so {c} \
                micrometres are --c {less}"
            ));
        }
        if matches!(self.spread, Spread::Lobe(_)) {
            warnings.push(ONE_LOBE.into());
        }
        warnings
    }

    /// Returns the numbers as a result, which has no standard errors.
    pub fn result(&self, table: TableResult) -> ResultFile {
        let mut result = self.ideal(table);
        result.spread_by_mrad(self.angular_spread_mrad);
        result
    }

    /// Returns the numbers without the angular spread.
    fn ideal(&self, table: TableResult) -> ResultFile {
        let shared = |value| {
            Parameter::Shared(Number {
                value: Some(value),
                standard_error: None,
            })
        };
        let (kernel, a_per_mm, a_times_r, wavelength_nm) = match &self.spread {
            Spread::Wave(spectrum) => (Kernel::Wave, None, None, Some(spectrum.clone())),
            Spread::Lobe(a) => (Kernel::Eq1, Some(shared(*a)), None, None),
            Spread::Angle(a) => (Kernel::Angular, None, Some(shared(*a)), None),
        };
        ResultFile {
            model: Family::Proposed,
            kernel,
            lobe: kernel.has_lobe().then_some(LobeShape::Radial),
            loss: Kind::Edge,
            forward: Forward::Spectral,
            sampling: None,
            iterations: 0,
            stop: BY_HAND.into(),
            seconds: 0.0,
            wavelength_nm,
            colours: None,
            c_mm: Some(Number {
                value: Some(self.c_mm),
                standard_error: None,
            }),
            a_per_mm,
            a_times_r,
            roughness: None,
            surface_roughness: None,
            own_blur_px: None,
            angular_spread_mrad: None,
            dihedral_errors_mrad: None,
            mu: self.mu.map(shared),
            azimuth_deg: None,
            covariance: Covariance {
                names: Vec::new(),
                matrix: Vec::new(),
            },
            bounds: Bounds::new(),
            candidates: Vec::new(),
            reference_transfer: None,
            reference_transfer_from: None,
            captures: Vec::new(),
            camera: CameraResult {
                pixel_pitch_mm: self.pixel_pitch_mm,
                lens_blur_mm: None,
                lens_exponent: None,
                lens_assumed: false,
                lens: Vec::new(),
                farthest_from_reference_deg: None,
            },
            half_mirror: self.half_mirror,
            polarisation: None,
            stray: Stray::default(),
            diffraction: Vec::new(),
            seen_in_mirror: Some(false),
            fit: None,
            domain: None,
            trusted: Vec::new(),
            table,
            warnings: self.warnings(),
        }
    }
}

impl ResultFile {
    /// Returns whether the numbers were given by hand, so that no photograph stands behind them.
    pub fn is_by_hand(&self) -> bool {
        self.stop == BY_HAND || self.is_nominal()
    }

    /// Sets the angular spread of the returned light, mrad.
    pub fn spread_by_mrad(&mut self, angular_spread_mrad: Option<f64>) {
        self.angular_spread_mrad = angular_spread_mrad.map(|value| Number {
            value: Some(value),
            standard_error: None,
        });
    }

    /// Returns whether the numbers are those of a nominal sheet.
    pub fn is_nominal(&self) -> bool {
        self.stop == NOMINAL
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_in_micrometres_are_asked_about() {
        for (c_mm, expected) in [(0.15, 0), (5.0, 0), (150.0, 1)] {
            let sheet = ByHand {
                c_mm,
                spread: Spread::Angle(750.0),
                angular_spread_mrad: None,
                mu: None,
                half_mirror: 0.25,
                pixel_pitch_mm: 0.1,
            };
            let warnings = sheet.warnings();
            assert_eq!(warnings.len(), expected, "{c_mm}: {warnings:?}");
            assert!(warnings.iter().all(|said| said.ends_with("--c 0.15")));
        }
    }
}
