//! Light that goes astray in a setup: the ghost of a thick half mirror, the haze of a cover film, and
//! the reflection in the sheet's own front.

use std::f64::consts::TAU;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Second image beside the first: that of the back of a thick half mirror.
///
/// A plate of thickness t and index n shows it 2 t tan(i') cos(i) aside, with i' the refracted angle:
/// 2.3 mm for 3 mm of glass at 45 degrees. A bare back behind a coat that reflects half of the light
/// gives it 4.3 % x 0.5^2/0.5 = 2.1 % of the first image.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ghost {
    /// Its light relative to that of the first image.
    pub share: f64,
    /// Its place along the plane of incidence, mm in the mid-air image.
    pub tangential_mm: f64,
    /// Its place across the plane of incidence, mm in the mid-air image.
    #[serde(default)]
    pub sagittal_mm: f64,
}

/// Haze of a film on the sheet: part of the light leaves in a wide cone.
///
/// A film of the haze H (ASTM D1003, the share beyond 2.5 degrees) that is passed twice has the share
/// 1 - (1 - H)^2: 4 % for H = 2 %.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Haze {
    /// Share of the light.
    pub share: f64,
    /// Standard deviation of its direction, per axis, degrees.
    pub spread_deg: f64,
}

/// What goes astray.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Stray {
    /// Ghost of the half mirror.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ghost: Option<Ghost>,
    /// Haze of a film on the sheet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub haze: Option<Haze>,
    /// Refractive index of a front of the sheet that reflects the source like a flat mirror.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub front_index: Option<f64>,
}

impl Ghost {
    /// Returns the OTF of both images along the unit vector `normal`, (tangential, sagittal), at a
    /// frequency in 1/mm; 1 at 0.
    pub fn otf(&self, normal: [f64; 2], frequency: f64) -> Complex64 {
        let along = normal[0] * self.tangential_mm + normal[1] * self.sagittal_mm;
        let second = Complex64::cis(-TAU * frequency * along) * self.share;
        (Complex64::ONE + second) / (1.0 + self.share)
    }
}

impl Haze {
    /// Returns the standard deviation of the hazy light in the image at the distance R, mm.
    pub fn spread_mm(&self, r_mm: f64) -> f64 {
        r_mm * self.spread_deg.to_radians()
    }

    /// Returns the OTF at a frequency in 1/mm; 1 at 0.
    pub fn otf(&self, r_mm: f64, frequency: f64) -> f64 {
        let turns = 0.5 * TAU * self.spread_mm(r_mm) * frequency;
        1.0 - self.share + self.share * (-2.0 * turns * turns).exp()
    }
}

impl Stray {
    /// Returns whether nothing goes astray.
    pub fn is_none(&self) -> bool {
        *self == Stray::default()
    }
}
