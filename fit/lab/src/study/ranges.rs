//! Random campaigns: the ranges of their parameters, and the draw of one campaign.

use std::f64::consts::TAU;
use std::path::Path;

use serde::{Deserialize, Deserializer};
use tables::Table;

use crate::simulate::Error;
use crate::simulate::PixelNoise;
use crate::simulate::cell;
use crate::simulate::lobe;
use crate::simulate::{ByIncidence, Params, PlantedCamera, PlantedEdge, PlantedSheet, PlantedShot};
use edges::document::{Bounds, Document, table};
use edges::document::{choices, positive, share, spectrum};
use edges::names::{Kernel, LobeShape, Spectrum};
use edges::readers;

/// Bright plateau of each mid-air photograph, where full scale is 1.
const BRIGHT: f64 = 0.8;

/// Smallest and largest tilt of an edge from the rows or columns, degrees.
const TILT_DEG: [f64; 2] = [4.0, 40.0];

/// Smallest retroreflected fraction at which a direction of the table is photographed.
const LEAST_ETA: f64 = 0.02;

readers! {
    index = Bounds::new("at least 1", |x| x >= 1.0);
    count = Bounds::new("between 1 and 1000", |x| (1.0..=1000.0).contains(&x));
    gain = Bounds::new("greater than 0 and at most 0.5", |x| x > 0.0 && x <= 0.5);
    bent = Bounds::new("greater than 0 and at most 10", |x| x > 0.0 && x <= 10.0);
    veil = Bounds::new("greater than 0 and at most 0.15", |x| x > 0.0 && x <= 0.15);
    hot = Bounds::new("greater than 0 and at most 0.1", |x| x > 0.0 && x <= 0.1);
    bits = Bounds::new("between 8 and 24", |x| (8.0..=24.0).contains(&x));
    quality = Bounds::new("between 1 and 100", |x| (1.0..=100.0).contains(&x));
}

/// Ranges from which campaigns are drawn, each as its two ends and evenly in the logarithm.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ranges {
    /// Refractive index behind the flat front; 1 for hollow cubes.
    #[serde(alias = "ior", deserialize_with = "index")]
    pub refractive_index: f64,
    /// True for a cell of a pair of cubes, false for a single cube.
    pub pair: bool,
    /// Shape of the lobe.
    #[serde(deserialize_with = "lobe")]
    pub lobe: LobeShape,
    /// Diffraction spread a, 1/mm.
    #[serde(deserialize_with = "positive")]
    pub a_per_mm: [f64; 2],
    /// Edge length c of the cubes, mm.
    #[serde(deserialize_with = "positive")]
    pub c_mm: [f64; 2],
    /// Reflectance mu.
    #[serde(deserialize_with = "share")]
    pub mu: [f64; 2],
    /// Number of photographs of a campaign without the reference.
    #[serde(deserialize_with = "count")]
    pub photographs: [f64; 2],
    /// Number of electrons at full scale.
    #[serde(deserialize_with = "positive")]
    pub electrons: [f64; 2],
    /// Floating distance, mm.
    #[serde(alias = "distance_mm", deserialize_with = "positive")]
    pub floating_distance_mm: [f64; 2],
    /// Uneven light: relative gain from the middle to the border of a photograph, in a random
    /// direction for each photograph. The light is even if this is `None`.
    #[serde(deserialize_with = "gain")]
    pub light: Option<[f64; 2]>,
    /// Vignetting: fall of the light to the corners of each photograph, relative to the middle.
    #[serde(deserialize_with = "gain")]
    pub vignetting: Option<[f64; 2]>,
    /// Height of the arc that the edge of each photograph follows, pixels, of either sign.
    #[serde(deserialize_with = "bent")]
    pub bow_px: Option<[f64; 2]>,
    /// Amplitude of a sinusoidal wave of each edge, pixels.
    #[serde(deserialize_with = "bent")]
    pub ripple_px: Option<[f64; 2]>,
    /// Light that is added everywhere, full scale 1.
    #[serde(deserialize_with = "veil")]
    pub veil: Option<[f64; 2]>,
    /// Share of the pixels that are at full scale whatever light they see.
    #[serde(deserialize_with = "hot")]
    pub hot_share: Option<[f64; 2]>,
    /// Bits of the converter.
    #[serde(deserialize_with = "bits")]
    pub bits: Option<[f64; 2]>,
    /// Quality of the JPEG as which the photographs are saved. They are not if this is `None`.
    #[serde(deserialize_with = "quality")]
    pub jpeg_quality: Option<[f64; 2]>,
    /// Kernels of [`Ranges::open_campaign`], all with equal probability.
    #[serde(deserialize_with = "kernels")]
    pub kernels: Vec<Kernel>,
    /// Wavelengths of the source, for the `wave` kernel.
    #[serde(rename = "wavelength_nm", deserialize_with = "spectrum")]
    pub spectrum: Option<Spectrum>,
    /// Fall of ln a from 0 to 45 degrees, in campaigns with one a per incidence.
    #[serde(deserialize_with = "positive")]
    pub a_fall: [f64; 2],
    /// Fall of ln mu from 0 to 45 degrees, in campaigns with one mu per incidence.
    #[serde(deserialize_with = "positive")]
    pub mu_fall: [f64; 2],
    /// Camera, except for its full well, which is drawn.
    #[serde(deserialize_with = "table")]
    pub camera: PlantedCamera,
}

impl Default for Ranges {
    fn default() -> Ranges {
        Ranges {
            refractive_index: 1.49,
            pair: true,
            lobe: LobeShape::Radial,
            a_per_mm: [1.5, 8.0],
            c_mm: [0.05, 0.5],
            mu: [0.2, 0.8],
            photographs: [2.0, 20.0],
            electrons: [500.0, 40_000.0],
            floating_distance_mm: [100.0, 400.0],
            light: None,
            vignetting: None,
            bow_px: None,
            ripple_px: None,
            veil: None,
            hot_share: None,
            bits: None,
            jpeg_quality: None,
            kernels: vec![Kernel::Eq1, Kernel::Angular, Kernel::Shift, Kernel::Lobe],
            spectrum: None,
            a_fall: [0.005, 1.5],
            mu_fall: [0.0005, 0.5],
            camera: PlantedCamera {
                width: 192,
                height: 128,
                pixel_pitch_mm: 0.08,
                ..PlantedCamera::default()
            },
        }
    }
}

impl Ranges {
    /// Reads and checks a file of ranges. Keys that it leaves out are as in [`Ranges::default`].
    ///
    /// # Errors
    /// Returns the first fault of the file, with its line.
    pub fn load(file: &Path) -> Result<Ranges, Error> {
        let document = Document::read(file)?;
        let ranges: Ranges = document.parse()?;
        if ranges.kernels.contains(&Kernel::Wave) && ranges.spectrum.is_none() {
            return Err(document
                .missing(0..0, "wavelength_nm", "the top level")
                .into());
        }
        Ok(ranges)
    }

    /// Returns the directions of a table that these campaigns photograph: incidence and azimuth,
    /// degrees.
    pub fn directions(&self, table: &Table) -> Vec<[f64; 2]> {
        let all = table.axes.directions().map(|(i, a)| [i, a]);
        all.filter(|&direction| self.eta(direction) >= LEAST_ETA)
            .collect()
    }

    /// Returns the retroreflected fraction of the ideal cell at (incidence, azimuth), degrees.
    pub fn eta(&self, [incidence, azimuth]: [f64; 2]) -> f64 {
        let (incidence, azimuth) = (incidence.to_radians(), azimuth.to_radians());
        let cubes = cell::shifts(incidence, azimuth, self.refractive_index, self.pair);
        cubes.iter().map(|cube| cube.retroreflected).sum::<f64>() / cubes.len() as f64
    }

    /// Draws campaign number `index` under `seed`, over the given directions (at least one).
    ///
    /// The campaign depends on these three arguments and the ranges alone.
    pub fn campaign(&self, seed: u64, index: u64, directions: &[[f64; 2]]) -> Params {
        let mut draw = PixelNoise::new(seed, index, u64::MAX);
        let a = log(&mut draw, self.a_per_mm);
        let c_mm = log(&mut draw, self.c_mm);
        let mu = log(&mut draw, self.mu);
        let full_well_e = log(&mut draw, self.electrons);
        // The probability of a whole number is its share of the range in the logarithm.
        let [least, most] = self.photographs;
        let count = log(&mut draw, [least, most + 1.0]).floor().min(most) as usize;
        let camera = PlantedCamera {
            full_well_e,
            ..self.camera.clone()
        };
        let half_mirror = camera.half_mirror_transmittance * camera.half_mirror_reflectance;
        let edge = |draw: &mut PixelNoise, exposure: f64| {
            let quarter = 90.0 * (4.0 * draw.uniform()).floor();
            let sign = if draw.uniform() < 0.5 { -1.0 } else { 1.0 };
            let tilt = TILT_DEG[0] + (TILT_DEG[1] - TILT_DEG[0]) * draw.uniform();
            PlantedEdge {
                normal_deg: quarter + sign * tilt,
                offset_px: 2.0 * draw.uniform() - 1.0,
                exposure,
                ..PlantedEdge::AERIAL
            }
        };
        let reference = edge(&mut draw, BRIGHT / camera.source_level);
        let captures = (0..count)
            .map(|_| {
                let direction = (draw.uniform() * directions.len() as f64) as usize;
                let [incidence_deg, azimuth_deg] = directions[direction];
                let light = camera.source_level * mu * half_mirror;
                let exposure = BRIGHT / (light * self.eta([incidence_deg, azimuth_deg]));
                PlantedShot {
                    edge: edge(&mut draw, exposure),
                    floating_distance_mm: log(&mut draw, self.floating_distance_mm),
                    path_mm: None,
                    incidence_deg,
                    azimuth_deg,
                    tangential_axis_deg: 0.0,
                    shifts: None,
                }
            })
            .collect();
        let mut params = Params {
            seed: (draw.uniform() * (1_u64 << 52) as f64) as u64,
            camera,
            truth: PlantedSheet {
                kernel: Kernel::Eq1,
                lobe: self.lobe,
                refractive_index: self.refractive_index,
                pair: self.pair,
                a: ByIncidence::Shared(a),
                c_mm,
                angular_spread_mrad: 0.0,
                mu: ByIncidence::Shared(mu),
                spectrum: None,
            },
            reference: Some(reference),
            captures,
        };
        self.disturb(&mut params, seed, index);
        params
    }

    /// Draws uneven light, bent edges and faults of the camera. Each kind has a stream of its own,
    /// so that it does not change the others.
    fn disturb(&self, params: &mut Params, seed: u64, index: u64) {
        let mut draws = [1, 3, 4, 5, 6].map(|k| PixelNoise::new(seed, index, u64::MAX - k));
        let [light, vignetting, bow, ripple, camera] = &mut draws;
        if let Some(range) = self.veil {
            params.camera.veil = log(camera, range);
        }
        if let Some(range) = self.hot_share {
            params.camera.hot_share = log(camera, range);
        }
        if let Some(range) = self.bits {
            params.camera.bits = log(camera, range).round() as u32;
        }
        if let Some(range) = self.jpeg_quality {
            params.camera.jpeg_quality = Some(log(camera, range).round() as u8);
        }
        let captures = params.captures.iter_mut().map(|shot| &mut shot.edge);
        for edge in captures.chain(&mut params.reference) {
            if let Some(range) = self.light {
                let (gain, turn) = (log(light, range), TAU * light.uniform());
                edge.light_to_right = gain * turn.cos();
                edge.light_to_bottom = gain * turn.sin();
            }
            if let Some(range) = self.vignetting {
                edge.vignetting = log(vignetting, range);
            }
            if let Some(range) = self.bow_px {
                let sign = if bow.uniform() < 0.5 { -1.0 } else { 1.0 };
                edge.bow_px = sign * log(bow, range);
            }
            if let Some(range) = self.ripple_px {
                edge.ripple_px = log(ripple, range);
            }
        }
    }

    /// Draws a campaign as [`Ranges::campaign`] does, and its terms too: one of the kernels, and
    /// one value or one per incidence for a and for mu, with equal probability.
    ///
    /// A value per incidence falls from angle to angle, as in real sheets.
    pub fn open_campaign(&self, seed: u64, index: u64, directions: &[[f64; 2]]) -> Params {
        let mut params = self.campaign(seed, index, directions);
        let mut draw = PixelNoise::new(seed, index, u64::MAX - 2);
        let kernel = self.kernels[(draw.uniform() * self.kernels.len() as f64) as usize];
        let mut angles: Vec<f64> = params.captures.iter().map(|s| s.incidence_deg).collect();
        angles.sort_by(f64::total_cmp);
        angles.dedup();
        let mut falling = |value: &ByIncidence, scale: f64, range: [f64; 2], may: bool| {
            let (own, fall) = (draw.uniform() < 0.5, log(&mut draw, range));
            let first = scale * value.at(angles[0]).unwrap_or(1.0);
            if own && may && angles.len() > 1 {
                let at = |&angle: &f64| (angle, first * (-fall * angle / 45.0).exp());
                ByIncidence::Table(angles.iter().map(at).collect())
            } else {
                ByIncidence::Shared(first)
            }
        };
        let truth = &mut params.truth;
        truth.kernel = kernel;
        truth.spectrum = self.spectrum.clone();
        // A of the angular kernel corresponds to the drawn a at the middle distance.
        let middle = (self.floating_distance_mm[0] * self.floating_distance_mm[1]).sqrt();
        let scale = kernel.distance_scale(middle);
        truth.a = falling(&truth.a, scale, self.a_fall, kernel.has_lobe());
        truth.mu = falling(&truth.mu, 1.0, self.mu_fall, true);
        params
    }
}

/// Draws a number evenly in the logarithm.
fn log(draw: &mut PixelNoise, [low, high]: [f64; 2]) -> f64 {
    low * (high / low).powf(draw.uniform())
}

fn kernels<'de, D: Deserializer<'de>>(value: D) -> Result<Vec<Kernel>, D::Error> {
    choices(value, &Kernel::NAMES, Kernel::from_name)
}
