//! MTF curves and luminance of a fitted sheet at other distances and directions.

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

/// Axis of the image along which the contrast of a pattern is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// x axis of the image, in the plane of incidence.
    Tangential,
    /// y axis of the image, across the plane of incidence.
    Sagittal,
}

impl Axis {
    /// Returns the unit vector of the axis in the mid-air image, (tangential, sagittal).
    pub const fn normal(self) -> [f64; 2] {
        match self {
            Axis::Tangential => [1.0, 0.0],
            Axis::Sagittal => [0.0, 1.0],
        }
    }
}

/// MTF of the mid-air image itself, without a camera, along one axis at one direction and distance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Prediction {
    /// Distance R: optical path from the sheet to the image, mm.
    pub floating_distance_mm: f64,
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Azimuth, degrees; null for a mean table.
    pub azimuth_deg: Option<f64>,
    /// Axis along which the contrast is measured.
    pub axis: Axis,
    /// Share eta of the arriving rays that the cell sends straight back, from the table.
    pub retroreflected: f64,
    /// True if the direction lies between the directions of the table.
    ///
    /// The prediction is less accurate there.
    pub interpolated: bool,
    /// Luminance of the mid-air image divided by that of the source, half mirror included.
    ///
    /// It is null without mu.
    pub luminance: Option<f64>,
    /// Frequency at which the MTF falls to one half, 1/mm.
    ///
    /// It is null if the MTF stays above one half, or if nothing returns.
    pub mtf50_per_mm: Option<f64>,
    /// MTF at the frequencies of [`Places`]; empty if nothing returns.
    pub mtf: Vec<f64>,
}

/// Distances, directions and frequencies of a prediction.
#[derive(Debug, Clone, PartialEq)]
pub struct Places {
    /// Distances R: optical paths from the sheet to the image, mm.
    pub floating_distance_mm: Vec<f64>,
    /// Incidence angles, degrees.
    pub incidence_deg: Vec<f64>,
    /// Azimuth, degrees; `None` for a mean table.
    pub azimuth_deg: Option<f64>,
    /// Frequencies, 1/mm.
    pub frequency_per_mm: Vec<f64>,
}

/// MTF at one place for all directions of contrast in the image.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Around {
    /// Distance R: optical path from the sheet to the image, mm.
    pub floating_distance_mm: f64,
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Azimuth, degrees; null for a mean table.
    pub azimuth_deg: Option<f64>,
    /// Directions of contrast, degrees: 0 is tangential, 90 is sagittal.
    ///
    /// Opposite directions have the same MTF.
    pub direction_deg: Vec<f64>,
    /// MTF as `[frequency][direction]`; empty if nothing returns.
    pub mtf: Vec<Vec<f64>>,
}

/// Sheet at one direction of incidence.
struct Seen<'a> {
    /// Result and table.
    sheet: &'a Fitted<'a>,
    /// Incidence, degrees.
    incidence_deg: f64,
    /// Direction of the table, interpolated where it lies between others.
    direction: Direction,
    /// Frequencies at which the MTF is evaluated, 1/mm.
    frequency_per_mm: &'a [f64],
}

impl<'a> Seen<'a> {
    /// Looks the direction up in the table.
    ///
    /// # Errors
    /// Returns [`Error::Direction`] if the table does not have the direction.
    fn new(sheet: &'a Fitted<'a>, places: &'a Places, incidence_deg: f64) -> Result<Self, Error> {
        Ok(Seen {
            sheet,
            incidence_deg,
            direction: sheet.table.direction(incidence_deg, places.azimuth_deg)?,
            frequency_per_mm: &places.frequency_per_mm,
        })
    }

    /// Computes the MTF of contrast along `normal` at every distance.
    ///
    /// Each MTF is empty if nothing returns.
    ///
    /// # Errors
    /// Returns [`Error::Unknown`] if the result lacks a parameter of the blur, and [`Error::Wave`]
    /// if the `wave` kernel lacks its data.
    fn mtf(&self, normal: [f64; 2], distance_mm: &[f64]) -> Result<Vec<Vec<f64>>, Error> {
        let (result, direction) = (self.sheet.result, &self.direction);
        let incidence = self.incidence_deg.to_radians();
        if self
            .sheet
            .returned(self.incidence_deg, direction.retroreflected)
            <= 0.0
        {
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

/// Predicts MTF and luminance at every distance and incidence, along both axes.
///
/// Parameters that were fitted per angle are interpolated linearly in the incidence. Beyond the
/// fitted angles they are constant.
///
/// # Errors
/// Returns an error in these cases:
///
/// - `Error::OtherCell` if the table is not one of the fitted cell,
/// - `Error::Unknown` if the result has only a bound for a parameter of the blur,
/// - `Error::Direction` if the table does not have a direction,
/// - `Error::Wave` if the `wave` kernel lacks a wavelength or polygons.
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
        let [tangential, sagittal] =
            axes.map(|axis| seen.mtf(axis.normal(), &places.floating_distance_mm));
        let curves = tangential?.into_iter().zip(sagittal?);
        let eta = seen.direction.retroreflected;
        for (&floating_distance_mm, curves) in places.floating_distance_mm.iter().zip(curves) {
            for (axis, mtf) in axes.into_iter().zip(<[_; 2]>::from(curves)) {
                predictions.push(Prediction {
                    floating_distance_mm,
                    incidence_deg,
                    azimuth_deg: places.azimuth_deg,
                    axis,
                    retroreflected: eta,
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

/// Count of directions of contrast in half a turn, for [`around`].
const DIRECTIONS: usize = 36;

/// Predicts the MTF for all directions of contrast, every 5 degrees, at every distance and
/// incidence.
///
/// It shows how the blur depends on the direction.
///
/// # Errors
/// Returns the errors of [`predict`].
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
            seen.mtf([tangential, sagittal], &places.floating_distance_mm)
        });
        let along = along.collect::<Result<Vec<_>, _>>()?;
        for (place, &floating_distance_mm) in places.floating_distance_mm.iter().enumerate() {
            // The image is real, so its MTF is even: the second half turn repeats the first.
            let circle = |k: usize| (0..=2 * DIRECTIONS).map(move |d| (d % DIRECTIONS, k));
            let curve = |k| circle(k).map(|(d, k)| along[d][place][k]).collect();
            let frequencies = along[0][place].len();
            all.push(Around {
                floating_distance_mm,
                incidence_deg,
                azimuth_deg: places.azimuth_deg,
                direction_deg: (0..=2 * DIRECTIONS).map(|d| d as f64 * step).collect(),
                mtf: (0..frequencies).map(curve).collect(),
            });
        }
    }
    Ok(all)
}
