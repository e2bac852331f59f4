//! Parameters of a simulated campaign: the content of truth.json, as TOML. Lengths are in mm,
//! angles in degrees.

use std::path::Path;

use serde::de::{Deserializer, Error as _, IgnoredAny};
use serde::{Deserialize, Serialize, Serializer};
use toml::{Spanned, Value};

use crate::simulate::camera::PlantedCamera;
use crate::simulate::cell::CubeShift;
use crate::simulate::error::Error;
use edges::document::{Bounded, Bounds, Document, FileLine, Table, table};
use edges::document::{choice, finite, incidence, not_negative, positive, spectrum, turn};
use edges::names::{Kernel, LobeShape, Spectrum};
use edges::readers;

readers! {
    seed = Bounds::new("a whole number, 0 or greater", |x| x >= 0.0);
    index = Bounds::new("at least 1", |x| x >= 1.0);
    gain = Bounds::new("between -0.5 and 0.5", |x| (-0.5..=0.5).contains(&x));
    fall = Bounds::new("at least 0 and below 0.9", |x| (0.0..0.9).contains(&x));
    bent = Bounds::new("between -10 and 10", |x| (-10.0..=10.0).contains(&x));
}

/// One number for all incidences, or one for each.
#[derive(Debug, Clone, PartialEq)]
pub enum ByIncidence {
    /// One number for all incidences.
    Shared(f64),
    /// Pairs of incidence (degrees) and value, by ascending incidence.
    Table(Vec<(f64, f64)>),
}

impl ByIncidence {
    /// Returns the value at an incidence, degrees; `None` if the table has no entry within 1e-9.
    pub fn at(&self, incidence_deg: f64) -> Option<f64> {
        match self {
            ByIncidence::Shared(value) => Some(*value),
            ByIncidence::Table(entries) => entries
                .iter()
                .find(|(angle, _)| (angle - incidence_deg).abs() < 1e-9)
                .map(|&(_, value)| value),
        }
    }
}

impl Serialize for ByIncidence {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            ByIncidence::Shared(value) => serializer.serialize_f64(*value),
            ByIncidence::Table(entries) => serializer.collect_map(
                entries
                    .iter()
                    .map(|(angle, value)| (angle.to_string(), value)),
            ),
        }
    }
}

/// The sheet that is photographed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlantedSheet {
    /// Blur terms of the sheet.
    pub kernel: Kernel,
    /// Shape of the lobe.
    pub lobe: LobeShape,
    /// Wavelengths of the source. The kernel `wave` needs them.
    #[serde(rename = "wavelength_nm")]
    pub spectrum: Option<Spectrum>,
    /// Refractive index behind the flat front face; 1 for hollow cubes.
    pub refractive_index: f64,
    /// Choice of cell: true for a pair of cubes, false for one cube.
    pub pair: bool,
    /// Diffraction spread: a in 1/mm, for `angular` A = a R without unit.
    pub a: ByIncidence,
    /// Corner size, mm.
    #[serde(rename = "c")]
    pub c_mm: f64,
    /// Standard deviation of the direction of the returned light across the plane of incidence,
    /// outside of the sheet, mrad.
    #[serde(skip_serializing_if = "is_zero")]
    pub angular_spread_mrad: f64,
    /// Reflectance mu.
    pub mu: ByIncidence,
}

/// Returns whether a number is 0, which is as good as absent.
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// The edge in one photograph.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default = "source_edge", deny_unknown_fields)]
pub struct PlantedEdge {
    /// Direction from dark to bright in the photograph, degrees from +x towards +y.
    #[serde(rename = "edge_normal_deg", deserialize_with = "turn")]
    pub normal_deg: f64,
    /// Number of columns by which the edge lies left of the centre of the picture. It is counted
    /// along the rows for any normal: towards the dark side if the normal points right.
    #[serde(deserialize_with = "finite")]
    pub offset_px: f64,
    /// Exposure relative to the reference.
    #[serde(deserialize_with = "positive")]
    pub exposure: f64,
    /// Uneven light: its increase from the middle of the picture to the right border, relative to
    /// the middle. The light varies linearly.
    #[serde(deserialize_with = "gain")]
    pub light_to_right: f64,
    /// Its increase to the lower border.
    #[serde(deserialize_with = "gain")]
    pub light_to_bottom: f64,
    /// Vignetting: the fall of the light from the middle of the picture to its corners, as
    /// cos^4 of the field angle.
    #[serde(deserialize_with = "fall")]
    pub vignetting: f64,
    /// Height of the arc of a circle that the edge follows over the height of the picture, pixels;
    /// positive where its ends lie towards the bright side.
    #[serde(deserialize_with = "bent")]
    pub bow_px: f64,
    /// Amplitude of a sinusoidal wave of the edge, one period over the height of the picture,
    /// pixels.
    #[serde(deserialize_with = "bent")]
    pub ripple_px: f64,
}

impl PlantedEdge {
    /// The source edge of a file that does not describe it.
    pub const SOURCE: PlantedEdge = PlantedEdge {
        normal_deg: 4.0,
        offset_px: 0.0,
        exposure: 1.0,
        light_to_right: 0.0,
        light_to_bottom: 0.0,
        vignetting: 0.0,
        bow_px: 0.0,
        ripple_px: 0.0,
    };
    /// A mid-air edge of a file that does not describe it.
    pub const AERIAL: PlantedEdge = PlantedEdge {
        normal_deg: 5.0,
        exposure: 6.0,
        ..PlantedEdge::SOURCE
    };
}

/// One photograph of the mid-air edge.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlantedShot {
    /// The edge in the photograph.
    #[serde(flatten)]
    pub edge: PlantedEdge,
    /// Floating distance, mm.
    pub floating_distance_mm: f64,
    /// Optical path from the sheet to the image, mm; `None` if it equals the floating distance.
    pub path_mm: Option<f64>,
    /// Incidence in the air, degrees.
    pub incidence_deg: f64,
    /// Azimuth, degrees.
    pub azimuth_deg: f64,
    /// Direction of the tangential axis in the photograph, degrees.
    pub tangential_axis_deg: f64,
    /// Shifts by polygon, each with its share of the arriving light, if a table gives them
    /// ([`Params::of_sheet`]). With `None` they are those of the ideal cube in closed form.
    #[serde(skip)]
    pub shifts: Option<Vec<CubeShift>>,
}

/// The parameters of a campaign to simulate. [`Params::load`] returns checked ones.
#[derive(Debug, Clone, PartialEq)]
pub struct Params {
    /// Seed of all noise.
    pub seed: u64,
    /// Camera, half mirror and source.
    pub camera: PlantedCamera,
    /// The sheet that is photographed.
    pub truth: PlantedSheet,
    /// The source edge, photographed without the sheet; `None` leaves the reference out.
    pub reference: Option<PlantedEdge>,
    /// The photographs of the mid-air edge; not empty.
    pub captures: Vec<PlantedShot>,
}

impl Params {
    /// Reads and checks a parameter file.
    ///
    /// # Errors
    /// Returns an `Error` with the line of the first fault: a file that cannot be read, text that
    /// is not TOML, a key that is unknown, missing or out of range, a table by incidence that lacks
    /// the incidence of a capture, or a file without captures.
    pub fn load(file: &Path) -> Result<Params, Error> {
        let document = Document::read(file)?;
        let tables: Tables = document.parse()?;
        let part = tables.truth.span();
        let truth = tables.truth.into_inner().0.checked();
        let truth = truth.map_err(|key| document.missing(part, key, "[truth]"))?;
        let mut captures = Vec::new();
        for table in tables.capture {
            let place = document.place(table.span());
            let shot = PlantedShot::from(table.into_inner().0);
            for (key, values) in [("a", &truth.a), ("mu", &truth.mu)] {
                if values.at(shot.incidence_deg).is_none() {
                    return Err(no_entry(place, key, shot.incidence_deg));
                }
            }
            captures.push(shot);
        }
        if captures.is_empty() {
            let none = "has no [[capture]]; add one for each photograph of the mid-air image";
            return Err(document.error(none).into());
        }
        Ok(Params {
            seed: tables.seed,
            camera: tables.camera,
            truth,
            reference: Some(tables.reference),
            captures,
        })
    }
}

/// Makes the error of a table by incidence that lacks the incidence of a capture.
pub(super) fn no_entry(capture: FileLine, key: &str, incidence_deg: f64) -> Error {
    let why =
        format!("incidence {incidence_deg} has no entry in the table `{key}` of [truth]; add it");
    capture.error(why).into()
}

/// A parameter file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Tables {
    #[serde(deserialize_with = "seed")]
    seed: u64,
    #[serde(default, rename = "tag")]
    _tag: IgnoredAny,
    #[serde(default, deserialize_with = "table")]
    camera: PlantedCamera,
    truth: Spanned<Table<TruthTable>>,
    #[serde(default = "source_edge", deserialize_with = "table")]
    reference: PlantedEdge,
    #[serde(default)]
    capture: Vec<Spanned<Table<CaptureTable>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TruthTable {
    #[serde(deserialize_with = "kernel")]
    kernel: Kernel,
    #[serde(default, deserialize_with = "lobe")]
    lobe: LobeShape,
    #[serde(default, deserialize_with = "spectrum")]
    wavelength_nm: Option<Spectrum>,
    #[serde(default, alias = "ior", deserialize_with = "index")]
    refractive_index: Option<f64>,
    pair: Option<bool>,
    #[serde(default, deserialize_with = "positive")]
    a: Option<ByIncidence>,
    #[serde(default, deserialize_with = "positive")]
    c: Option<f64>,
    #[serde(default, deserialize_with = "not_negative")]
    angular_spread_mrad: f64,
    #[serde(deserialize_with = "positive")]
    mu: ByIncidence,
}

impl TruthTable {
    /// Returns the sheet, or the key that its kernel needs and that is missing.
    fn checked(self) -> Result<PlantedSheet, &'static str> {
        let kernel = self.kernel;
        if kernel.has_waves() && self.wavelength_nm.is_none() {
            return Err("wavelength_nm");
        }
        // A parameter that the kernel does not have need not be given.
        let a = (!kernel.has_lobe()).then_some(ByIncidence::Shared(1.0));
        let c_mm = (!kernel.has_c()).then_some(1.0);
        Ok(PlantedSheet {
            kernel,
            lobe: self.lobe,
            spectrum: self.wavelength_nm,
            refractive_index: self.refractive_index.unwrap_or(1.0),
            pair: self.pair.unwrap_or(true),
            a: self.a.or(a).ok_or("a")?,
            c_mm: self.c.or(c_mm).ok_or("c")?,
            angular_spread_mrad: self.angular_spread_mrad,
            mu: self.mu,
        })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CaptureTable {
    #[serde(deserialize_with = "positive")]
    floating_distance_mm: f64,
    #[serde(default, deserialize_with = "positive")]
    path_mm: Option<f64>,
    #[serde(deserialize_with = "incidence")]
    incidence_deg: f64,
    #[serde(default, deserialize_with = "turn")]
    azimuth_deg: f64,
    #[serde(default, deserialize_with = "turn")]
    tangential_axis_deg: f64,
    #[serde(default, deserialize_with = "turn")]
    edge_normal_deg: Option<f64>,
    #[serde(default, deserialize_with = "finite")]
    offset_px: f64,
    #[serde(default, deserialize_with = "positive")]
    exposure: Option<f64>,
    #[serde(default, deserialize_with = "gain")]
    light_to_right: f64,
    #[serde(default, deserialize_with = "gain")]
    light_to_bottom: f64,
    #[serde(default, deserialize_with = "fall")]
    vignetting: f64,
    #[serde(default, deserialize_with = "bent")]
    bow_px: f64,
    #[serde(default, deserialize_with = "bent")]
    ripple_px: f64,
}

impl From<CaptureTable> for PlantedShot {
    fn from(table: CaptureTable) -> PlantedShot {
        let usual = PlantedEdge::AERIAL;
        PlantedShot {
            edge: PlantedEdge {
                normal_deg: table.edge_normal_deg.unwrap_or(usual.normal_deg),
                offset_px: table.offset_px,
                exposure: table.exposure.unwrap_or(usual.exposure),
                light_to_right: table.light_to_right,
                light_to_bottom: table.light_to_bottom,
                vignetting: table.vignetting,
                bow_px: table.bow_px,
                ripple_px: table.ripple_px,
            },
            floating_distance_mm: table.floating_distance_mm,
            path_mm: table.path_mm,
            incidence_deg: table.incidence_deg,
            azimuth_deg: table.azimuth_deg,
            tangential_axis_deg: table.tangential_axis_deg,
            shifts: None,
        }
    }
}

fn source_edge() -> PlantedEdge {
    PlantedEdge::SOURCE
}

fn kernel<'de, D: Deserializer<'de>>(value: D) -> Result<Kernel, D::Error> {
    choice(value, &Kernel::NAMES, Kernel::from_name)
}

pub(crate) fn lobe<'de, D: Deserializer<'de>>(value: D) -> Result<LobeShape, D::Error> {
    choice(value, &LobeShape::NAMES, LobeShape::from_name)
}

/// A number, or a table of numbers by incidence.
impl Bounded for ByIncidence {
    fn within<'de, D: Deserializer<'de>>(value: D, bounds: Bounds) -> Result<Self, D::Error> {
        let number = |value: &Value| {
            let number = value.as_float().or(value.as_integer().map(|n| n as f64));
            let wrong = "must be a number or a table of numbers; change the value";
            bounds.checked(number.ok_or_else(|| D::Error::custom(wrong))?)
        };
        let value = Value::deserialize(value)?;
        let Value::Table(entries) = value else {
            return number(&value).map(ByIncidence::Shared);
        };
        let entry = |(name, value): (&String, &Value)| match name.parse::<f64>() {
            Ok(angle) if angle.is_finite() => Ok((angle, number(value)?)),
            _ => Err(D::Error::custom(format!(
                "has the entry `{name}`, which is not an incidence in degrees; write it as \"15\" \
                or \"22.5\""
            ))),
        };
        let mut table: Vec<_> = entries.iter().map(entry).collect::<Result<_, _>>()?;
        table.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(ByIncidence::Table(table))
    }
}
