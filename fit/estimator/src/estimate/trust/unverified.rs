//! What the estimate takes on trust: numbers of the manifest and of the table that no photograph
//! can check, each with the effect of a small error on c, a and mu.

use serde::{Deserialize, Serialize};

/// Number that is taken on trust.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum UnverifiedInput {
    /// Width of a pixel in the plane of the mid-air image, mm.
    PixelPitchMm,
    /// Floating distances of all photographs, mm.
    FloatingDistanceMm,
    /// Transmittance times reflectance of the half mirror.
    HalfMirror,
    /// Exposure of the reference photograph.
    ReferenceExposure,
    /// Exposures of the other photographs over that of the reference.
    Exposure,
    /// Wavelengths of the source, nm.
    WavelengthNm,
    /// Refractive index of the table.
    RefractiveIndex,
    /// Incidences of all photographs, degrees.
    IncidenceDeg,
    /// Azimuths of all photographs, degrees.
    AzimuthDeg,
    /// Tangential axes of all photographs, degrees.
    TangentialAxisDeg,
    /// Lens: that the mid-air photographs are as sharp as the reference.
    Lens,
    /// Dihedral angles: that those of all cubes are 90 degrees, or as in the table.
    DihedralAngles,
    /// Camera: that its values are proportional to the light, as the transfer says.
    Linearity,
    /// Cell of the table.
    Cell,
}

impl UnverifiedInput {
    /// Returns the name in files.
    pub const fn name(self) -> &'static str {
        match self {
            UnverifiedInput::PixelPitchMm => "pixel_pitch_mm",
            UnverifiedInput::FloatingDistanceMm => "floating_distance_mm",
            UnverifiedInput::HalfMirror => "half_mirror",
            UnverifiedInput::ReferenceExposure => "reference_exposure",
            UnverifiedInput::Exposure => "exposure",
            UnverifiedInput::WavelengthNm => "wavelength_nm",
            UnverifiedInput::RefractiveIndex => "refractive_index",
            UnverifiedInput::IncidenceDeg => "incidence_deg",
            UnverifiedInput::AzimuthDeg => "azimuth_deg",
            UnverifiedInput::TangentialAxisDeg => "tangential_axis_deg",
            UnverifiedInput::Lens => "lens",
            UnverifiedInput::DihedralAngles => "dihedral_angles",
            UnverifiedInput::Linearity => "linearity",
            UnverifiedInput::Cell => "cell",
        }
    }
}

/// Relative changes of the parameters if the number were larger by its step.
///
/// A change is null if the kernel has no such parameter, if the photographs only bound it, if the
/// step cannot be computed, or if the fit is so poor that it has no bounds either. Of several values by incidence it is the largest change.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Effect {
    /// Change of c.
    pub c_mm: Option<f64>,
    /// Change of a, or of A under the kernel `angular`.
    pub a_per_mm: Option<f64>,
    /// Change of mu.
    pub mu: Option<f64>,
}

/// Number that is taken on trust, with the effect of a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Unverified {
    /// The number.
    pub what: UnverifiedInput,
    /// Value of the number; null if the photographs differ, and for a cell.
    pub value: Option<f64>,
    /// The step, with its unit: `1 %`, `1 deg`, another table, or the error by rounding of an
    /// exposure from Exif data.
    pub step: String,
    /// Effect of the step.
    pub effect: Effect,
}

/// Returns one sentence that names, for each of c, a and mu, the inputs whose steps change it most;
/// `None` if nothing is known.
pub fn in_words(trusted: &[Unverified]) -> Option<String> {
    const NAMED: usize = 2;
    let most = ["c", "a", "mu"]
        .into_iter()
        .enumerate()
        .filter_map(|(k, name)| {
            let of = |effect: &Effect| [effect.c_mm, effect.a_per_mm, effect.mu][k];
            let known = trusted
                .iter()
                .filter_map(|entry| Some((entry, of(&entry.effect)?)))
                .filter(|(_, share)| *share != 0.0);
            let mut known: Vec<(&Unverified, f64)> = known.collect();
            known.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
            let causes = known.iter().take(NAMED).map(|(entry, share)| {
                let (what, step, percent) = (entry.what.name(), &entry.step, 100.0 * share);
                format!("{percent:+.2} % by {step} of {what}")
            });
            let causes: Vec<String> = causes.collect();
            (!causes.is_empty()).then(|| format!("{name} {}", causes.join(" and ")))
        });
    let most: Vec<String> = most.collect();
    (!most.is_empty()).then(|| format!("taken on trust, largest effects: {}", most.join("; ")))
}
