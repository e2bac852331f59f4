//! What a fitted sheet would show: MTF curves and luminance at other distances and directions.

use serde::Serialize;
use tables::Table;

use crate::baseline::Baseline;
use crate::kernel::Kernel;
use crate::lobe::Shape;
use crate::report::ResultFile;
use crate::sheet::Fitted;
use crate::shift::ShiftLine;
pub use crate::spot::Error;
use crate::view::Model;
use crate::wave::WaveLine;

/// Orientation of a pattern: along which axis its contrast is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// In the plane of incidence.
    Tangential,
    /// Across it.
    Sagittal,
}

impl Axis {
    /// Unit normal in the aerial image, (tangential, sagittal).
    pub const fn normal(self) -> [f64; 2] {
        match self {
            Axis::Tangential => [1.0, 0.0],
            Axis::Sagittal => [0.0, 1.0],
        }
    }
}

/// The MTF of the mid-air image itself (no camera) along one axis, at one direction and distance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Prediction {
    /// Floating distance (optical path), mm.
    pub distance_mm: f64,
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Azimuth, degrees; null for a mean table.
    pub azimuth_deg: Option<f64>,
    /// Direction of the contrast.
    pub axis: Axis,
    /// Retroreflected fraction of the table.
    pub eta: f64,
    /// Whether the direction lies between those of the table, which costs accuracy.
    pub interpolated: bool,
    /// Luminance of the mid-air image over that of the source, half mirror included; null without mu.
    pub luminance: Option<f64>,
    /// Frequency at which the MTF is one half, 1/mm; null where it stays above, or nothing returns.
    pub mtf50_per_mm: Option<f64>,
    /// The MTF at the frequencies asked for; empty where nothing returns.
    pub mtf: Vec<f64>,
}

/// Where to predict.
#[derive(Debug, Clone, PartialEq)]
pub struct Places {
    /// Floating distances, mm.
    pub distance_mm: Vec<f64>,
    /// Incidence angles, degrees.
    pub incidence_deg: Vec<f64>,
    /// Azimuth, degrees; `None` for a mean table.
    pub azimuth_deg: Option<f64>,
    /// Frequencies, 1/mm.
    pub frequency_per_mm: Vec<f64>,
}

/// Predicts MTF and luminance at every distance and incidence, along both axes. Parameters fitted per angle are
/// interpolated linearly in the incidence and held constant beyond the fitted angles.
///
/// # Errors
/// [`Error::OtherCell`], [`Error::Unknown`], [`Error::Direction`], [`Error::Wave`].
pub fn predict(
    result: &ResultFile,
    table: &Table,
    places: &Places,
) -> Result<Vec<Prediction>, Error> {
    let sheet = Fitted::new(result, table)?;
    let mut predictions = Vec::new();
    for &incidence_deg in &places.incidence_deg {
        let direction = table.direction(incidence_deg, places.azimuth_deg)?;
        let blur = sheet.blur(incidence_deg)?;
        for &distance_mm in &places.distance_mm {
            for axis in [Axis::Tangential, Axis::Sagittal] {
                let normal = axis.normal();
                let shift = ShiftLine::new(&direction, incidence_deg.to_radians(), normal);
                let waves = (result.kernel == Kernel::Wave && shift.is_some())
                    .then(|| {
                        let spectrum = result.wavelength_nm.as_ref();
                        WaveLine::new(&direction, incidence_deg.to_radians(), normal, spectrum)
                    })
                    .transpose()?;
                let index = table.provenance.refractive_index;
                let incidence = incidence_deg.to_radians();
                let model = Model {
                    kernel: result.kernel,
                    shape: result.lobe.unwrap_or(Shape::Radial),
                    shift: shift.as_ref(),
                    wave: waves.as_ref(),
                    baseline: Baseline::new(result.kernel, incidence, index, normal),
                    r_mm: distance_mm,
                    normal,
                };
                let mtf_at = |f: f64| model.otf(blur, f)[0].norm();
                let returns = sheet.returned(incidence_deg, direction.eta) > 0.0;
                let mtf: Vec<f64> = if returns {
                    places.frequency_per_mm.iter().map(|&f| mtf_at(f)).collect()
                } else {
                    Vec::new()
                };
                predictions.push(Prediction {
                    distance_mm,
                    incidence_deg,
                    azimuth_deg: places.azimuth_deg,
                    axis,
                    eta: direction.eta,
                    interpolated: direction.interpolated,
                    luminance: sheet.luminance(incidence_deg, direction.eta),
                    mtf50_per_mm: if returns {
                        crate::sfr::crossing(&places.frequency_per_mm, &mtf, 0.5)
                    } else {
                        None
                    },
                    mtf,
                });
            }
        }
    }
    Ok(predictions)
}
