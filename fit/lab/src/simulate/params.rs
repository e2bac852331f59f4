//! Parameters of a simulated campaign: the content of truth.json, as TOML. Lengths are in mm,
//! angles in degrees.

use std::f64::consts::{PI, SQRT_2};
use std::path::Path;

use serde::de::{Deserializer, Error as _, IgnoredAny};
use serde::{Deserialize, Serialize, Serializer};
use toml::{Spanned, Value};

use crate::simulate::cell::CubeShift;
use crate::simulate::error::Error;
use edges::document::{Bounded, Bounds, Document, FileLine, Table, table};
use edges::document::{choice, finite, incidence, not_negative, positive, share, spectrum, turn};
use edges::names::{Kernel, LobeShape, Spectrum};
use edges::readers;

readers! {
    seed = Bounds::new("a whole number, 0 or greater", |x| x >= 0.0);
    index = Bounds::new("at least 1", |x| x >= 1.0);
    size = Bounds::new("between 8 and 20000", |x| (8.0..=20_000.0).contains(&x));
    lens = Bounds::new("between 0.1 and 100", |x| (0.1..=100.0).contains(&x));
    ratio = Bounds::new("at least 0 and below 1", |x| (0.0..1.0).contains(&x));
    bits = Bounds::new("between 1 and 24", |x| (1.0..=24.0).contains(&x));
    hot = Bounds::new("at least 0 and at most 0.1", |x| (0.0..=0.1).contains(&x));
    quality = Bounds::new("a whole number between 1 and 100", |x| {
        (1.0..=100.0).contains(&x) && x.fract() == 0.0
    });
    halo = Bounds::new("at least 0 and at most 0.5", |x| (0.0..=0.5).contains(&x));
    cutoff = Bounds::new("between 0.1 and 8", |x| (0.1..=8.0).contains(&x));
    sharpening = Bounds::new("at least 0 and at most 4", |x| (0.0..=4.0).contains(&x));
    gain = Bounds::new("between -0.5 and 0.5", |x| (-0.5..=0.5).contains(&x));
    fall = Bounds::new("at least 0 and below 0.9", |x| (0.0..0.9).contains(&x));
    bent = Bounds::new("between -10 and 10", |x| (-10.0..=10.0).contains(&x));
}

/// The camera, and the light that reaches it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlantedCamera {
    /// Number of columns.
    #[serde(deserialize_with = "size")]
    pub width: usize,
    /// Number of rows.
    #[serde(deserialize_with = "size")]
    pub height: usize,
    /// Side of a pixel in the plane of the mid-air image, mm.
    #[serde(deserialize_with = "positive")]
    pub pixel_pitch_mm: f64,
    /// True if the camera sees the sheet in the half mirror: rows of the picture then run along
    /// the sagittal axis, else against it.
    pub seen_in_mirror: bool,
    /// Standard deviation of the lens blur, pixels, >= 0.1.
    #[serde(deserialize_with = "lens")]
    pub sigma_px: f64,
    /// Standard deviation along y, if it is another than along x, pixels: an astigmatic lens.
    #[serde(deserialize_with = "lens")]
    pub sigma_down_px: Option<f64>,
    /// Perfect lens with a round pupil instead of the Gaussian one: the frequency at which its OTF
    /// ends, cycles per pixel.
    #[serde(deserialize_with = "cutoff")]
    pub pupil_cutoff_per_px: Option<f64>,
    /// Share of the light that the lens scatters into a halo.
    #[serde(deserialize_with = "halo")]
    pub halo_share: f64,
    /// Length over which the halo's line spread falls to 1/e, pixels.
    #[serde(deserialize_with = "positive")]
    pub halo_px: f64,
    /// Sharpening by the camera: the share of the difference between a pixel and the mean of 3 x 3
    /// pixels that is added to it.
    #[serde(deserialize_with = "sharpening")]
    pub sharpening: f64,
    /// Bright level of the source at exposure 1, full scale 1.
    #[serde(deserialize_with = "positive")]
    pub source_level: f64,
    /// Transmittance of the half mirror.
    #[serde(deserialize_with = "share")]
    pub half_mirror_transmittance: f64,
    /// Reflectance of the half mirror.
    #[serde(deserialize_with = "share")]
    pub half_mirror_reflectance: f64,
    /// Light that is added everywhere, after the exposure, full scale 1.
    #[serde(deserialize_with = "not_negative")]
    pub veil: f64,
    /// Ratio of the source's dark level to its bright level.
    #[serde(deserialize_with = "ratio")]
    pub dark_ratio: f64,
    /// Number of electrons at level 1.
    #[serde(deserialize_with = "positive")]
    pub full_well_e: f64,
    /// Standard deviation of the read noise, electrons.
    #[serde(deserialize_with = "not_negative")]
    pub read_noise_e: f64,
    /// Number of bits of the converter: levels are whole multiples of 1/(2^bits - 1).
    #[serde(deserialize_with = "bits")]
    pub bits: u32,
    /// Share of the pixels that are at full scale whatever light they see.
    #[serde(deserialize_with = "hot")]
    pub hot_share: f64,
    /// Quality of the JPEG as which photographs are saved, 1 to 100: 8 bits, sRGB-coded. `None`
    /// stands for EXR.
    #[serde(deserialize_with = "jpeg_quality")]
    pub jpeg_quality: Option<u8>,
}

impl PlantedCamera {
    /// Describes size and noise in a line.
    pub(crate) fn words(&self) -> String {
        format!(
            "pictures of {} x {} pixels of {} mm, full well of {} electrons, read noise of {}, {} \
            bits, lens blur of {} px",
            self.width,
            self.height,
            self.pixel_pitch_mm,
            self.full_well_e,
            self.read_noise_e,
            self.bits,
            self.sigma_px
        )
    }

    /// Returns the blur of the lens, mm: its OTF is exp(-(f blur)^2) = exp(-2 (pi sigma f)^2).
    pub(crate) fn lens_blur_mm(&self) -> f64 {
        SQRT_2 * PI * self.sigma_px * self.pixel_pitch_mm
    }
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

/// The camera of a parameter file that does not describe one.
impl Default for PlantedCamera {
    fn default() -> PlantedCamera {
        PlantedCamera {
            width: 320,
            height: 256,
            pixel_pitch_mm: 0.05,
            seen_in_mirror: false,
            sigma_px: 0.55,
            sigma_down_px: None,
            pupil_cutoff_per_px: None,
            halo_share: 0.0,
            halo_px: 20.0,
            sharpening: 0.0,
            source_level: 0.9,
            half_mirror_transmittance: 0.5,
            half_mirror_reflectance: 0.5,
            veil: 0.004,
            dark_ratio: 0.01,
            full_well_e: 40_000.0,
            read_noise_e: 3.0,
            bits: 14,
            hot_share: 0.0,
            jpeg_quality: None,
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

fn jpeg_quality<'de, D: Deserializer<'de>>(value: D) -> Result<Option<u8>, D::Error> {
    quality(value).map(|quality: f64| Some(quality as u8))
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
