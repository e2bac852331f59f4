//! Campaigns drawn at random: the ranges, and one campaign of them.

use std::path::Path;

use tables::Table;

use crate::captures::keys::{Bounds, Document, Section};
use crate::kernel::Kernel;
use crate::lobe::Shape;
use crate::simulate::noise::PixelNoise;
use crate::simulate::{self, ByIncidence, CAMERA, Camera, Edge, Error, Params, Shot, Truth, cell};

const ROOT: [&str; 10] = [
    "ior",
    "pair",
    "lobe",
    "a_per_mm",
    "c_mm",
    "mu",
    "photographs",
    "electrons",
    "distance_mm",
    "camera",
];

/// Bright plateau of every aerial photograph, full scale 1.
const BRIGHT: f64 = 0.8;

/// Smallest tilt of an edge from the rows or columns, and largest, degrees.
const TILT_DEG: [f64; 2] = [4.0, 40.0];

/// Retroreflected fraction below which a direction of the table is not photographed.
const LEAST_ETA: f64 = 0.02;

/// What is drawn from, each range evenly in the logarithm.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranges {
    /// Refractive index behind the flat front.
    pub ior: f64,
    /// Pair of cubes rather than one.
    pub pair: bool,
    /// Shape of the lobe.
    pub lobe: Shape,
    /// Diffraction spread, 1/mm.
    pub a_per_mm: [f64; 2],
    /// Edge length of the cubes, mm.
    pub c_mm: [f64; 2],
    /// Reflectance.
    pub mu: [f64; 2],
    /// Photographs of a campaign, the reference not counted.
    pub photographs: [f64; 2],
    /// Electrons at full scale.
    pub electrons: [f64; 2],
    /// Floating distance, mm.
    pub distance_mm: [f64; 2],
    /// The camera; its full well is drawn.
    pub camera: Camera,
}

impl Default for Ranges {
    fn default() -> Ranges {
        Ranges {
            ior: 1.49,
            pair: true,
            lobe: Shape::Radial,
            a_per_mm: [1.5, 8.0],
            c_mm: [0.05, 0.5],
            mu: [0.2, 0.8],
            photographs: [2.0, 20.0],
            electrons: [500.0, 40_000.0],
            distance_mm: [100.0, 400.0],
            camera: Camera {
                width: 192,
                height: 128,
                pixel_pitch_mm: 0.08,
                ..Camera::default()
            },
        }
    }
}

impl Ranges {
    /// Reads and checks a file of ranges; what it leaves out is as in [`Ranges::default`].
    ///
    /// # Errors
    /// The first thing that is wrong, with its line.
    pub fn load(file: &Path) -> Result<Ranges, Error> {
        const INDEX: Bounds = Bounds {
            words: "at least 1",
            holds: |x| x >= 1.0,
        };
        const COUNT: Bounds = Bounds {
            words: "between 1 and 1000",
            holds: |x| (1.0..=1000.0).contains(&x),
        };
        let document = Document::read(file)?;
        let table = document.parse()?;
        let root = Section::root(&document, &table, &ROOT)?;
        let default = Ranges::default();
        let own = root.section("camera", &CAMERA)?;
        let range = |key, bounds, default| range(&root, key, bounds, default);
        Ok(Ranges {
            ior: root.number("ior", INDEX)?.unwrap_or(default.ior),
            pair: root.flag("pair")?.unwrap_or(default.pair),
            lobe: root
                .choice("lobe", &Shape::NAMES, Shape::from_name)?
                .unwrap_or(default.lobe),
            a_per_mm: range("a_per_mm", Bounds::POSITIVE, default.a_per_mm)?,
            c_mm: range("c_mm", Bounds::POSITIVE, default.c_mm)?,
            mu: range("mu", Bounds::SHARE, default.mu)?,
            photographs: range("photographs", COUNT, default.photographs)?,
            electrons: range("electrons", Bounds::POSITIVE, default.electrons)?,
            distance_mm: range("distance_mm", Bounds::POSITIVE, default.distance_mm)?,
            camera: match &own {
                Some(keys) => simulate::camera(Some(keys))?,
                None => default.camera,
            },
        })
    }

    /// Directions of a table that these campaigns photograph: incidence and azimuth, degrees.
    pub fn directions(&self, table: &Table) -> Vec<[f64; 2]> {
        let axes = &table.axes;
        let all = axes
            .incidence_deg
            .iter()
            .flat_map(|&i| axes.azimuth_deg.iter().map(move |&a| [i, a]));
        all.filter(|&direction| self.eta(direction) >= LEAST_ETA)
            .collect()
    }

    /// Retroreflected fraction of the ideal cell at (incidence, azimuth), degrees.
    pub fn eta(&self, [incidence, azimuth]: [f64; 2]) -> f64 {
        let (incidence, azimuth) = (incidence.to_radians(), azimuth.to_radians());
        let cubes = cell::shifts(incidence, azimuth, self.ior, self.pair);
        cubes.iter().map(|cube| cube.eta).sum::<f64>() / cubes.len() as f64
    }

    /// Campaign number `index` under `seed`, over the given directions (at least one): a function of these alone.
    pub fn campaign(&self, seed: u64, index: u64, directions: &[[f64; 2]]) -> Params {
        let mut draw = PixelNoise::new(seed, index, u64::MAX);
        let log =
            |draw: &mut PixelNoise, [low, high]: [f64; 2]| low * (high / low).powf(draw.uniform());
        let a = log(&mut draw, self.a_per_mm);
        let c_mm = log(&mut draw, self.c_mm);
        let mu = log(&mut draw, self.mu);
        let full_well_e = log(&mut draw, self.electrons);
        // Whole numbers: each is as likely as its share of the logarithm.
        let [least, most] = self.photographs;
        let count = log(&mut draw, [least, most + 1.0]).floor().min(most) as usize;
        let camera = Camera {
            full_well_e,
            ..self.camera.clone()
        };
        let half_mirror = camera.half_mirror_transmittance * camera.half_mirror_reflectance;
        let edge = |draw: &mut PixelNoise, exposure: f64| {
            let quarter = 90.0 * (4.0 * draw.uniform()).floor();
            let sign = if draw.uniform() < 0.5 { -1.0 } else { 1.0 };
            let tilt = TILT_DEG[0] + (TILT_DEG[1] - TILT_DEG[0]) * draw.uniform();
            Edge {
                normal_deg: quarter + sign * tilt,
                offset_px: 2.0 * draw.uniform() - 1.0,
                exposure,
            }
        };
        let reference = edge(&mut draw, BRIGHT / camera.source_level);
        let captures = (0..count)
            .map(|_| {
                let direction = (draw.uniform() * directions.len() as f64) as usize;
                let [incidence_deg, azimuth_deg] = directions[direction];
                let light = camera.source_level * mu * half_mirror;
                let exposure = BRIGHT / (light * self.eta([incidence_deg, azimuth_deg]));
                Shot {
                    edge: edge(&mut draw, exposure),
                    floating_distance_mm: log(&mut draw, self.distance_mm),
                    path_mm: None,
                    incidence_deg,
                    azimuth_deg,
                    tangential_axis_deg: 0.0,
                }
            })
            .collect();
        Params {
            seed: (draw.uniform() * (1_u64 << 52) as f64) as u64,
            camera,
            truth: Truth {
                kernel: Kernel::Eq1,
                lobe: self.lobe,
                ior: self.ior,
                pair: self.pair,
                a: ByIncidence::Shared(a),
                c_mm,
                mu: ByIncidence::Shared(mu),
                spectrum: None,
            },
            reference: Some(reference),
            captures,
        }
    }
}

/// `key = { from = ..., to = ... }`.
fn range(
    root: &Section<'_>,
    key: &'static str,
    bounds: Bounds,
    default: [f64; 2],
) -> Result<[f64; 2], Error> {
    let Some(keys) = root.section(key, &["from", "to"])? else {
        return Ok(default);
    };
    let from = keys.required("from", keys.number("from", bounds)?)?;
    let to = keys.required("to", keys.number("to", bounds)?)?;
    if from > to {
        return Err(Error::Range {
            place: keys.place().clone(),
            key,
            from,
            to,
        });
    }
    Ok([from, to])
}
