//! What a fitted sheet would show: MTF curves and luminance at other distances and directions.

use serde::Serialize;
use tables::{Direction, Table};

use crate::model::Baseline;
use crate::model::Model;
use crate::model::wave;
use crate::names::Kernel;
use crate::names::LobeShape;
use crate::predict::error::Error;
use crate::predict::sheet::Fitted;
use crate::result::ResultFile;
use tables::ShiftLine;

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
    /// Luminance of the mid-air image over that of the source, half mirror included; null without
    /// mu.
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

/// The MTF at one place over the direction of contrast in the image.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Around {
    /// Floating distance (optical path), mm.
    pub distance_mm: f64,
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Azimuth, degrees; null for a mean table.
    pub azimuth_deg: Option<f64>,
    /// Directions of contrast, degrees: 0 is tangential, 90 sagittal; opposite ones are alike.
    pub direction_deg: Vec<f64>,
    /// `[frequency][direction]`; empty where nothing returns.
    pub mtf: Vec<Vec<f64>>,
}

/// What is seen of the sheet along one direction of incidence.
struct Seen<'a> {
    sheet: &'a Fitted<'a>,
    incidence_deg: f64,
    direction: Direction,
    frequency_per_mm: &'a [f64],
}

impl<'a> Seen<'a> {
    fn new(sheet: &'a Fitted<'a>, places: &'a Places, incidence_deg: f64) -> Result<Self, Error> {
        Ok(Seen {
            sheet,
            incidence_deg,
            direction: sheet.table.direction(incidence_deg, places.azimuth_deg)?,
            frequency_per_mm: &places.frequency_per_mm,
        })
    }

    /// The MTF at each distance of contrast along `normal`; none where nothing returns.
    fn mtf(&self, normal: [f64; 2], distance_mm: &[f64]) -> Result<Vec<Vec<f64>>, Error> {
        let (result, direction) = (self.sheet.result, &self.direction);
        let incidence = self.incidence_deg.to_radians();
        if self.sheet.returned(self.incidence_deg, direction.eta) <= 0.0 {
            return Ok(vec![Vec::new(); distance_mm.len()]);
        }
        let blur = self.sheet.blur(self.incidence_deg)?;
        let shift = ShiftLine::new(direction, incidence, normal);
        let waves = (result.kernel == Kernel::Wave && shift.is_some())
            .then(|| wave::line(direction, incidence, normal, result.wavelength_nm.as_ref()))
            .transpose()?;
        let index = self.sheet.table.provenance.refractive_index;
        let at = |&r_mm: &f64| {
            let model = Model {
                kernel: result.kernel,
                shape: result.lobe.unwrap_or(LobeShape::Radial),
                shift: shift.as_ref(),
                wave: waves.as_ref(),
                baseline: Baseline::new(result.kernel, incidence, index, normal),
                r_mm,
                normal,
            };
            let mtf = |&f: &f64| model.otf(blur, f)[0].norm();
            self.frequency_per_mm.iter().map(mtf).collect()
        };
        Ok(distance_mm.iter().map(at).collect())
    }
}

/// Predicts MTF and luminance at every distance and incidence, along both axes. Parameters fitted
/// per angle are interpolated linearly in the incidence and held constant beyond the fitted angles.
///
/// # Errors
/// `Error::OtherCell`, `Error::Unknown`, `Error::Direction`, `Error::Wave`.
pub fn predict(
    result: &ResultFile,
    table: &Table,
    places: &Places,
) -> Result<Vec<Prediction>, Error> {
    let sheet = Fitted::new(result, table)?;
    let mut predictions = Vec::new();
    for &incidence_deg in &places.incidence_deg {
        let seen = Seen::new(&sheet, places, incidence_deg)?;
        let axes = [Axis::Tangential, Axis::Sagittal];
        let [tangential, sagittal] = axes.map(|axis| seen.mtf(axis.normal(), &places.distance_mm));
        let curves = tangential?.into_iter().zip(sagittal?);
        let eta = seen.direction.eta;
        for (&distance_mm, curves) in places.distance_mm.iter().zip(curves) {
            for (axis, mtf) in axes.into_iter().zip(<[_; 2]>::from(curves)) {
                predictions.push(Prediction {
                    distance_mm,
                    incidence_deg,
                    azimuth_deg: places.azimuth_deg,
                    axis,
                    eta,
                    interpolated: seen.direction.interpolated,
                    luminance: sheet.luminance(incidence_deg, eta),
                    mtf50_per_mm: (!mtf.is_empty())
                        .then(|| crate::photographs::crossing(&places.frequency_per_mm, &mtf, 0.5))
                        .flatten(),
                    mtf,
                });
            }
        }
    }
    Ok(predictions)
}

/// Directions of contrast between tangential and back, for [`around`].
const DIRECTIONS: usize = 36;

/// Predicts the MTF over all directions of contrast, every 5 degrees, at every distance and
/// incidence: its anisotropy.
///
/// # Errors
/// As [`predict`].
pub(crate) fn around(
    result: &ResultFile,
    table: &Table,
    places: &Places,
) -> Result<Vec<Around>, Error> {
    let sheet = Fitted::new(result, table)?;
    let step = 180.0 / DIRECTIONS as f64;
    let mut all = Vec::new();
    for &incidence_deg in &places.incidence_deg {
        let seen = Seen::new(&sheet, places, incidence_deg)?;
        let along = (0..DIRECTIONS).map(|k| {
            let (sagittal, tangential) = (k as f64 * step).to_radians().sin_cos();
            seen.mtf([tangential, sagittal], &places.distance_mm)
        });
        let along = along.collect::<Result<Vec<_>, _>>()?;
        for (place, &distance_mm) in places.distance_mm.iter().enumerate() {
            // The modulus of a real image's spectrum is even: the other half turn repeats the
            // first.
            let circle = |k: usize| (0..=2 * DIRECTIONS).map(move |d| (d % DIRECTIONS, k));
            let curve = |k| circle(k).map(|(d, k)| along[d][place][k]).collect();
            let frequencies = along[0][place].len();
            all.push(Around {
                distance_mm,
                incidence_deg,
                azimuth_deg: places.azimuth_deg,
                direction_deg: (0..=2 * DIRECTIONS).map(|d| d as f64 * step).collect(),
                mtf: (0..frequencies).map(curve).collect(),
            });
        }
    }
    Ok(all)
}
