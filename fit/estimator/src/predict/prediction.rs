//! MTF curves and luminance of a fitted sheet at other distances and directions.

use serde::Serialize;
use tables::{Direction, Table};

use crate::error::Error;
use crate::predict::curve::{Curve, Derived, Line};
use crate::predict::domain::{Viewpoint, outside};
use crate::predict::interval::{Uncertainty, interval};
use crate::predict::sheet::Fitted;
use crate::result::{Number, ResultFile};

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
    /// Ends of the 95 % interval of the luminance, by the covariance of the result.
    ///
    /// It is null without mu, and if the result has no covariance of mu.
    pub luminance_interval: Option<[f64; 2]>,
    /// Frequency at which the MTF first falls to one half, 1/mm.
    ///
    /// It is null if the MTF stays above one half, or if nothing returns.
    pub mtf50_per_mm: Option<f64>,
    /// Ends of the 95 % interval of MTF50, 1/mm; null like it, and without covariance.
    pub mtf50_per_mm_interval: Option<[f64; 2]>,
    /// Frequency at which the MTF first falls to a tenth, 1/mm; null like MTF50.
    pub mtf10_per_mm: Option<f64>,
    /// Ends of the 95 % interval of MTF10, 1/mm; null like it, and without covariance.
    pub mtf10_per_mm_interval: Option<[f64; 2]>,
    /// MTF at the frequencies of [`Places`]; empty if nothing returns.
    pub mtf: Vec<f64>,
    /// Ends of the 95 % interval of each MTF; empty without covariance, and if nothing returns.
    pub mtf_interval: Vec<[f64; 2]>,
    /// Keys of the domain of the result (such as `incidence_deg`) in which this place lies outside
    /// of the photographs.
    pub outside: Vec<&'static str>,
}

impl Prediction {
    /// Returns the distance and the direction of the prediction.
    pub fn place(&self) -> Viewpoint {
        Viewpoint {
            incidence_deg: self.incidence_deg,
            azimuth_deg: self.azimuth_deg,
            r_mm: self.floating_distance_mm,
        }
    }
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
pub struct Around {
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
/// - `Error::Table` if the table does not have a direction,
/// - `Error::Waves` if the `wave` kernel lacks a wavelength or polygons.
pub fn predict(
    result: &ResultFile,
    table: &Table,
    places: &Places,
) -> Result<Vec<Prediction>, Error> {
    let sheet = Fitted::new(result, table)?;
    let mut predictions = Vec::new();
    for &incidence_deg in &places.incidence_deg {
        let at = Incidence::new(sheet, incidence_deg, places.azimuth_deg)?;
        let lines = at.lines()?;
        for &r_mm in &places.floating_distance_mm {
            for line in &lines {
                let seen = line.at(r_mm);
                predictions.push(at.prediction(line.axis, r_mm, &seen, &places.frequency_per_mm));
            }
        }
    }
    Ok(predictions)
}

/// Sheet at one direction of incidence.
pub(crate) struct Incidence<'a> {
    pub sheet: Fitted<'a>,
    pub incidence_deg: f64,
    azimuth_deg: Option<f64>,
    pub direction: Direction,
    /// Directions at one standard error of a fitted azimuth to either side; else none.
    pub sides: Vec<Direction>,
    pub uncertainty: Uncertainty<'a>,
}

/// Sheet at one direction of incidence, along one axis of the image.
pub(crate) struct AxisLine {
    axis: Axis,
    line: Option<Line>,
    sides: Vec<Option<Line>>,
}

impl AxisLine {
    /// Returns the MTF at the distance R, mm.
    pub(crate) fn at(&self, r_mm: f64) -> AxisCurve<'_> {
        let sides = self.sides.iter();
        AxisCurve {
            curve: self.line.as_ref().map(|line| line.at(r_mm)),
            sides: sides
                .filter_map(|line| Some(line.as_ref()?.at(r_mm)))
                .collect(),
        }
    }
}

/// MTF along one axis at one distance.
pub(crate) struct AxisCurve<'a> {
    /// Curve of the direction; `None` without light.
    pub curve: Option<Curve<'a>>,
    /// Curves at one standard error of a fitted azimuth to either side; else none.
    pub sides: Vec<Curve<'a>>,
}

impl AxisCurve<'_> {
    /// Returns the standard error that the azimuth causes in a number of the curve.
    pub(crate) fn by_azimuth(&self, number: impl Fn(&Curve) -> Option<f64>) -> f64 {
        let sides: Option<Vec<f64>> = self.sides.iter().map(number).collect();
        half_difference(sides.as_deref().unwrap_or_default())
    }
}

/// Returns half the difference of two numbers, or 0 without them.
pub(crate) fn half_difference(sides: &[f64]) -> f64 {
    match sides {
        [low, high] => 0.5 * (high - low).abs(),
        _ => 0.0,
    }
}

impl<'a> Incidence<'a> {
    /// Looks up a direction of a sheet.
    ///
    /// # Errors
    /// Returns [`Error::Table`] if the table does not have the direction.
    pub(crate) fn new(
        sheet: Fitted<'a>,
        incidence_deg: f64,
        azimuth_deg: Option<f64>,
    ) -> Result<Incidence<'a>, Error> {
        Ok(Incidence {
            sheet,
            incidence_deg,
            azimuth_deg,
            direction: sheet.table.direction(incidence_deg, azimuth_deg)?,
            sides: sheet.beside(incidence_deg, azimuth_deg),
            uncertainty: Uncertainty::new(sheet.result, incidence_deg),
        })
    }

    /// Projects the direction on both axes of the image.
    ///
    /// # Errors
    /// Returns the errors of [`Line::new`].
    pub(crate) fn lines(&self) -> Result<[AxisLine; 2], Error> {
        let of = |axis: Axis| -> Result<AxisLine, Error> {
            let line = |own| Line::new(&self.sheet, own, self.incidence_deg, axis.normal());
            Ok(AxisLine {
                axis,
                line: line(&self.direction)?,
                sides: self.sides.iter().map(line).collect::<Result<_, _>>()?,
            })
        };
        Ok([of(Axis::Tangential)?, of(Axis::Sagittal)?])
    }

    /// Makes the prediction of one curve.
    fn prediction(
        &self,
        axis: Axis,
        floating_distance_mm: f64,
        seen: &AxisCurve<'_>,
        frequency_per_mm: &[f64],
    ) -> Prediction {
        let (sheet, uncertainty) = (&self.sheet, &self.uncertainty);
        let curve = seen.curve.as_ref();
        let points = |curve: &Curve| -> Vec<Derived> {
            let frequencies = frequency_per_mm.iter();
            frequencies.map(|&f| curve.derived(f)).collect()
        };
        let mtf = curve.map(points).unwrap_or_default();
        let crossing = |level| {
            let found = curve?.falls_to(level)?;
            let beside = seen.by_azimuth(|side| Some(side.falls_to(level)?.value));
            let error = uncertainty.of_blur(&found, beside);
            let ends = error.map(|error| interval(found.value, error, [0.0, f64::INFINITY]));
            Some((found.value, ends))
        };
        let (half, tenth) = (crossing(0.5), crossing(0.1));
        let place = Viewpoint {
            incidence_deg: self.incidence_deg,
            azimuth_deg: self.azimuth_deg,
            r_mm: floating_distance_mm,
        };
        let luminance = self.luminance();
        let domain = sheet.result.domain.as_ref();
        let intervals = mtf.iter().zip(frequency_per_mm).map(|(point, &f)| {
            let beside = seen.by_azimuth(|side| Some(side.mtf(f)));
            let error = uncertainty.of_blur(point, beside)?;
            Some(interval(point.value, error, [0.0, 1.0]))
        });
        Prediction {
            floating_distance_mm,
            incidence_deg: self.incidence_deg,
            azimuth_deg: self.azimuth_deg,
            axis,
            retroreflected: self.direction.retroreflected,
            interpolated: self.direction.interpolated,
            luminance: luminance.value,
            luminance_interval: luminance
                .value
                .zip(luminance.standard_error)
                .map(|(value, error)| interval(value, error, [0.0, f64::INFINITY])),
            mtf50_per_mm: half.map(|(value, _)| value),
            mtf50_per_mm_interval: half.and_then(|(_, interval)| interval),
            mtf10_per_mm: tenth.map(|(value, _)| value),
            mtf10_per_mm_interval: tenth.and_then(|(_, interval)| interval),
            mtf_interval: intervals.collect::<Option<_>>().unwrap_or_default(),
            mtf: mtf.iter().map(|point| point.value).collect(),
            outside: domain.map_or_else(Vec::new, |domain| {
                outside(domain, sheet.table.provenance.symmetry, &place)
            }),
        }
    }

    /// Returns the luminance of the mid-air image divided by that of the source.
    pub(crate) fn luminance(&self) -> Number {
        let sheet = &self.sheet;
        let of = |eta| sheet.luminance(self.incidence_deg, eta);
        let eta = self.direction.retroreflected;
        let Some(luminance) = of(eta) else {
            return Number::UNKNOWN;
        };
        let by_rays = of(eta + self.direction.standard_error).map_or(0.0, |more| more - luminance);
        let sides: Option<Vec<f64>> = self
            .sides
            .iter()
            .map(|side| of(side.retroreflected))
            .collect();
        let by_azimuth = half_difference(sides.as_deref().unwrap_or_default());
        let beside = by_rays.hypot(by_azimuth);
        Number {
            value: Some(luminance),
            standard_error: self.uncertainty.of_luminance(self.light_by_mu(), beside),
        }
    }

    /// Returns the derivative of the luminance by mu.
    pub(crate) fn light_by_mu(&self) -> f64 {
        let returned = (self.sheet).returned(self.incidence_deg, self.direction.retroreflected);
        returned * self.sheet.result.half_mirror
    }
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
pub fn around(result: &ResultFile, table: &Table, places: &Places) -> Result<Vec<Around>, Error> {
    let sheet = Fitted::new(result, table)?;
    let step = 180.0 / DIRECTIONS as f64;
    let mut all = Vec::new();
    for &incidence_deg in &places.incidence_deg {
        let direction = table.direction(incidence_deg, places.azimuth_deg)?;
        let along = (0..DIRECTIONS).map(|k| -> Result<Vec<Vec<f64>>, Error> {
            let (sagittal, tangential) = (k as f64 * step).to_radians().sin_cos();
            let line = Line::new(&sheet, &direction, incidence_deg, [tangential, sagittal])?;
            let mtf = |curve: Curve| {
                places
                    .frequency_per_mm
                    .iter()
                    .map(|&f| curve.mtf(f))
                    .collect()
            };
            let at = |&r_mm: &f64| {
                line.as_ref()
                    .map(|line| mtf(line.at(r_mm)))
                    .unwrap_or_default()
            };
            Ok(places.floating_distance_mm.iter().map(at).collect())
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
