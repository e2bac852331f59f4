//! The camera of a simulated campaign, and the light that reaches it.

use std::f64::consts::{PI, SQRT_2};

use serde::de::Deserializer;
use serde::{Deserialize, Serialize};

use edges::document::Bounds;
use edges::document::{not_negative, positive, share};
use edges::readers;

readers! {
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

fn jpeg_quality<'de, D: Deserializer<'de>>(value: D) -> Result<Option<u8>, D::Error> {
    quality(value).map(|quality: f64| Some(quality as u8))
}
