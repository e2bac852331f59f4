//! Parameters of a simulated campaign: the content of truth.json, as TOML. Lengths are in mm,
//! angles in degrees.

use crate::names::Kernel;
use crate::names::LobeShape;
use crate::names::Spectrum;
use std::path::Path;

use crate::document::Bounds;
use crate::document::FileLine;
use crate::document::{Document, NumberOrTable, Section};
use crate::simulate::cell::CubeShift;
use crate::simulate::error::Error;

/// Keys and tables of the top level.
const ROOT: [&str; 6] = ["seed", "tag", "camera", "truth", "reference", "capture"];
/// Keys of the table `[camera]`.
pub(crate) const CAMERA: [&str; 15] = [
    "width",
    "height",
    "pixel_pitch_mm",
    "seen_in_mirror",
    "sigma_px",
    "source_level",
    "half_mirror_transmittance",
    "half_mirror_reflectance",
    "veil",
    "dark_ratio",
    "full_well_e",
    "read_noise_e",
    "bits",
    "hot_share",
    "jpeg_quality",
];
/// Keys of the table `[truth]`.
const TRUTH: [&str; 9] = [
    "kernel",
    "lobe",
    "wavelength_nm",
    "refractive_index",
    "ior",
    "pair",
    "a",
    "c",
    "mu",
];
/// Keys of the table `[reference]`.
const REFERENCE: [&str; 8] = [
    "edge_normal_deg",
    "offset_px",
    "exposure",
    "light_to_right",
    "light_to_bottom",
    "vignetting",
    "bow_px",
    "ripple_px",
];
/// Keys of a table `[[capture]]`.
const CAPTURE: [&str; 13] = [
    "floating_distance_mm",
    "path_mm",
    "incidence_deg",
    "azimuth_deg",
    "tangential_axis_deg",
    "edge_normal_deg",
    "offset_px",
    "exposure",
    "light_to_right",
    "light_to_bottom",
    "vignetting",
    "bow_px",
    "ripple_px",
];

/// The camera, and the light that reaches it.
#[derive(Debug, Clone, PartialEq)]
pub struct PlantedCamera {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Side of a pixel in the plane of the mid-air image, mm.
    pub pixel_pitch_mm: f64,
    /// True if the camera sees the sheet in the half mirror: rows of the picture then run along
    /// the sagittal axis, else against it.
    pub seen_in_mirror: bool,
    /// Standard deviation of the lens blur, pixels, >= 0.1.
    pub sigma_px: f64,
    /// Bright level of the source at exposure 1, full scale 1.
    pub source_level: f64,
    /// Transmittance of the half mirror.
    pub half_mirror_transmittance: f64,
    /// Reflectance of the half mirror.
    pub half_mirror_reflectance: f64,
    /// Light that is added everywhere, after the exposure, full scale 1.
    pub veil: f64,
    /// Ratio of the source's dark level to its bright level.
    pub dark_ratio: f64,
    /// Number of electrons at level 1.
    pub full_well_e: f64,
    /// Standard deviation of the read noise, electrons.
    pub read_noise_e: f64,
    /// Number of bits of the converter: levels are whole multiples of 1/(2^bits - 1).
    pub bits: u32,
    /// Share of the pixels that are at full scale whatever light they see.
    pub hot_share: f64,
    /// Quality of the JPEG as which photographs are saved, 1 to 100: 8 bits, sRGB-coded. `None`
    /// stands for EXR.
    pub jpeg_quality: Option<u8>,
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

/// The sheet that is photographed.
#[derive(Debug, Clone, PartialEq)]
pub struct PlantedSheet {
    /// Blur terms of the sheet.
    pub kernel: Kernel,
    /// Shape of the lobe.
    pub lobe: LobeShape,
    /// Wavelengths of the source. The kernel `wave` needs them.
    pub spectrum: Option<Spectrum>,
    /// Refractive index behind the flat front face; 1 for hollow cubes.
    pub refractive_index: f64,
    /// Choice of cell: true for a pair of cubes, false for one cube.
    pub pair: bool,
    /// Diffraction spread: a in 1/mm, for `angular` A = a R without unit.
    pub a: ByIncidence,
    /// Corner size, mm.
    pub c_mm: f64,
    /// Reflectance mu.
    pub mu: ByIncidence,
}

/// The edge in one photograph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlantedEdge {
    /// Direction from dark to bright in the photograph, degrees from +x towards +y.
    pub normal_deg: f64,
    /// Number of columns by which the edge lies left of the centre of the picture. It is counted
    /// along the rows for any normal: towards the dark side if the normal points right.
    pub offset_px: f64,
    /// Exposure relative to the reference.
    pub exposure: f64,
    /// Uneven light: its increase from the middle of the picture to the right and to the lower
    /// border, relative to the middle. The light varies linearly.
    pub light: [f64; 2],
    /// Vignetting: the fall of the light from the middle of the picture to its corners, as
    /// cos^4 of the field angle.
    pub vignetting: f64,
    /// Height of the arc of a circle that the edge follows over the height of the picture, pixels;
    /// positive where its ends lie towards the bright side.
    pub bow_px: f64,
    /// Amplitude of a sinusoidal wave of the edge, one period over the height of the picture,
    /// pixels.
    pub ripple_px: f64,
}

impl PlantedEdge {
    /// The source edge of a file that does not describe it.
    pub const SOURCE: PlantedEdge = PlantedEdge {
        normal_deg: 4.0,
        offset_px: 0.0,
        exposure: 1.0,
        light: [0.0; 2],
        vignetting: 0.0,
        bow_px: 0.0,
        ripple_px: 0.0,
    };
    /// A mid-air edge of a file that does not describe it.
    pub const AERIAL: PlantedEdge = PlantedEdge {
        normal_deg: 5.0,
        offset_px: 0.0,
        exposure: 6.0,
        light: [0.0; 2],
        vignetting: 0.0,
        bow_px: 0.0,
        ripple_px: 0.0,
    };
}

/// One photograph of the mid-air edge.
#[derive(Debug, Clone, PartialEq)]
pub struct PlantedShot {
    /// The edge in the photograph.
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
        let table = document.parse()?;
        let root = Section::root(&document, &table, &ROOT)?;
        let seed = root.required("seed", root.whole("seed", 0)?)?;
        let camera = camera(root.section("camera", &CAMERA)?.as_ref())?;
        let truth = truth(&root.required("truth", root.section("truth", &TRUTH)?)?)?;
        let reference = match root.section("reference", &REFERENCE)? {
            Some(keys) => Some(edge(&keys, PlantedEdge::SOURCE)?),
            None => Some(PlantedEdge::SOURCE),
        };
        let mut captures = Vec::new();
        for keys in root.sections("capture", &CAPTURE)? {
            let shot = shot(&keys)?;
            check_entries(&truth, &shot, keys.place())?;
            captures.push(shot);
        }
        if captures.is_empty() {
            return Err(Error::NoCaptures {
                file: file.to_owned(),
            });
        }
        Ok(Params {
            seed,
            camera,
            truth,
            reference,
            captures,
        })
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

/// Reads the table `[camera]`. Keys that are missing have the values of the default camera.
pub(crate) fn camera(keys: Option<&Section<'_>>) -> Result<PlantedCamera, Error> {
    const SIZE: Bounds = Bounds {
        words: "between 8 and 20000",
        holds: |x| (8.0..=20_000.0).contains(&x),
    };
    const LENS: Bounds = Bounds {
        words: "between 0.1 and 100",
        holds: |x| (0.1..=100.0).contains(&x),
    };
    const RATIO: Bounds = Bounds {
        words: "at least 0 and below 1",
        holds: |x| (0.0..1.0).contains(&x),
    };
    const BITS: Bounds = Bounds {
        words: "between 1 and 24",
        holds: |x| (1.0..=24.0).contains(&x),
    };
    const HOT: Bounds = Bounds {
        words: "at least 0 and at most 0.1",
        holds: |x| (0.0..=0.1).contains(&x),
    };
    const QUALITY: Bounds = Bounds {
        words: "a whole number between 1 and 100",
        holds: |x| (1.0..=100.0).contains(&x) && x.fract() == 0.0,
    };
    let default = PlantedCamera::default();
    let Some(keys) = keys else { return Ok(default) };
    let number =
        |key, bounds, default| Ok::<f64, Error>(keys.number(key, bounds)?.unwrap_or(default));
    let whole = |key, bounds: Bounds, default: u64| {
        keys.whole(key, 1)?;
        Ok::<u64, Error>(
            keys.number(key, bounds)?
                .map_or(default, |value| value as u64),
        )
    };
    Ok(PlantedCamera {
        width: whole("width", SIZE, default.width as u64)? as usize,
        height: whole("height", SIZE, default.height as u64)? as usize,
        pixel_pitch_mm: number("pixel_pitch_mm", Bounds::POSITIVE, default.pixel_pitch_mm)?,
        seen_in_mirror: keys.flag("seen_in_mirror")?.unwrap_or(false),
        sigma_px: number("sigma_px", LENS, default.sigma_px)?,
        source_level: number("source_level", Bounds::POSITIVE, default.source_level)?,
        half_mirror_transmittance: number(
            "half_mirror_transmittance",
            Bounds::SHARE,
            default.half_mirror_transmittance,
        )?,
        half_mirror_reflectance: number(
            "half_mirror_reflectance",
            Bounds::SHARE,
            default.half_mirror_reflectance,
        )?,
        veil: number("veil", Bounds::NOT_NEGATIVE, default.veil)?,
        dark_ratio: number("dark_ratio", RATIO, default.dark_ratio)?,
        full_well_e: number("full_well_e", Bounds::POSITIVE, default.full_well_e)?,
        read_noise_e: number("read_noise_e", Bounds::NOT_NEGATIVE, default.read_noise_e)?,
        bits: whole("bits", BITS, default.bits.into())? as u32,
        hot_share: number("hot_share", HOT, default.hot_share)?,
        jpeg_quality: keys
            .number("jpeg_quality", QUALITY)?
            .map(|quality| quality as u8),
    })
}

fn truth(keys: &Section<'_>) -> Result<PlantedSheet, Error> {
    const INDEX: Bounds = Bounds {
        words: "at least 1",
        holds: |x| x >= 1.0,
    };
    let kernel = keys.required(
        "kernel",
        keys.choice("kernel", &Kernel::NAMES, Kernel::from_name)?,
    )?;
    let lobe = keys
        .choice("lobe", &LobeShape::NAMES, LobeShape::from_name)?
        .unwrap_or(LobeShape::Radial);
    // A parameter that the kernel does not have need not be given.
    let a = match kernel {
        Kernel::Shift | Kernel::Wave => {
            by_incidence(keys, "a")?.unwrap_or(ByIncidence::Shared(1.0))
        }
        _ => keys.required("a", by_incidence(keys, "a")?)?,
    };
    let c_mm = match kernel {
        Kernel::Lobe => keys.number("c", Bounds::POSITIVE)?.unwrap_or(1.0),
        _ => keys.required("c", keys.number("c", Bounds::POSITIVE)?)?,
    };
    let spectrum = keys.spectrum()?;
    if kernel == Kernel::Wave {
        keys.required("wavelength_nm", spectrum.as_ref())?;
    }
    Ok(PlantedSheet {
        kernel,
        lobe,
        spectrum,
        refractive_index: keys.number("refractive_index", INDEX)?.unwrap_or(1.0),
        pair: keys.flag("pair")?.unwrap_or(true),
        a,
        c_mm,
        mu: keys.required("mu", by_incidence(keys, "mu")?)?,
    })
}

fn by_incidence(keys: &Section<'_>, key: &'static str) -> Result<Option<ByIncidence>, Error> {
    match keys.number_or_table(key, Bounds::POSITIVE)? {
        None => Ok(None),
        Some(NumberOrTable::Number(value)) => Ok(Some(ByIncidence::Shared(value))),
        Some(NumberOrTable::Table(entries)) => {
            let angle = |(name, value): (String, f64)| match name.parse::<f64>() {
                Ok(angle) if angle.is_finite() => Ok((angle, value)),
                _ => Err(Error::EntryName {
                    place: keys.place_of(key),
                    key,
                    name,
                }),
            };
            let mut table = entries
                .into_iter()
                .map(angle)
                .collect::<Result<Vec<_>, _>>()?;
            table.sort_by(|a, b| a.0.total_cmp(&b.0));
            Ok(Some(ByIncidence::Table(table)))
        }
    }
}

fn edge(keys: &Section<'_>, default: PlantedEdge) -> Result<PlantedEdge, Error> {
    const GAIN: Bounds = Bounds {
        words: "between -0.5 and 0.5",
        holds: |x| (-0.5..=0.5).contains(&x),
    };
    const FALL: Bounds = Bounds {
        words: "at least 0 and below 0.9",
        holds: |x| (0.0..0.9).contains(&x),
    };
    const BENT: Bounds = Bounds {
        words: "between -10 and 10",
        holds: |x| (-10.0..=10.0).contains(&x),
    };
    let gain = |key| Ok::<f64, Error>(keys.number(key, GAIN)?.unwrap_or(0.0));
    Ok(PlantedEdge {
        light: [gain("light_to_right")?, gain("light_to_bottom")?],
        vignetting: keys.number("vignetting", FALL)?.unwrap_or(0.0),
        bow_px: keys.number("bow_px", BENT)?.unwrap_or(0.0),
        ripple_px: keys.number("ripple_px", BENT)?.unwrap_or(0.0),
        normal_deg: keys
            .number("edge_normal_deg", Bounds::TURN)?
            .unwrap_or(default.normal_deg),
        offset_px: keys
            .number("offset_px", Bounds::FINITE)?
            .unwrap_or(default.offset_px),
        exposure: keys
            .number("exposure", Bounds::POSITIVE)?
            .unwrap_or(default.exposure),
    })
}

fn shot(keys: &Section<'_>) -> Result<PlantedShot, Error> {
    let distance = keys.number("floating_distance_mm", Bounds::POSITIVE)?;
    let incidence = keys.number("incidence_deg", Bounds::INCIDENCE)?;
    Ok(PlantedShot {
        edge: edge(keys, PlantedEdge::AERIAL)?,
        floating_distance_mm: keys.required("floating_distance_mm", distance)?,
        path_mm: keys.number("path_mm", Bounds::POSITIVE)?,
        incidence_deg: keys.required("incidence_deg", incidence)?,
        azimuth_deg: keys.number("azimuth_deg", Bounds::TURN)?.unwrap_or(0.0),
        tangential_axis_deg: keys
            .number("tangential_axis_deg", Bounds::TURN)?
            .unwrap_or(0.0),
        shifts: None,
    })
}

fn check_entries(truth: &PlantedSheet, shot: &PlantedShot, place: &FileLine) -> Result<(), Error> {
    for (key, values) in [("a", &truth.a), ("mu", &truth.mu)] {
        if values.at(shot.incidence_deg).is_none() {
            return Err(Error::NoEntry {
                place: place.clone(),
                key,
                incidence_deg: shot.incidence_deg,
            });
        }
    }
    Ok(())
}
