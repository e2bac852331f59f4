//! The request for a bake, as typed.

use crate::plan::default;
use num_complex::Complex64;
use tables::options::{Back, Losses, Method, Sampler, SceneOptions};

/// Options of `bake trace` that shape the table, as typed.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// Text of `--incidence`: angles, degrees.
    pub incidence: String,
    /// Text of `--azimuth`: angles in degrees, `full`, `full:STEP` or `mean`.
    pub azimuth: String,
    /// Value of `--refractive-index`, where it is given.
    pub refractive_index: Option<f64>,
    /// Value of `--back`.
    pub back: Back,
    /// Value of `--losses`.
    pub losses: Losses,
    /// Value of `--reflectance`, where it is given.
    pub reflectance: Option<f64>,
    /// Complex refractive index n + ik of `--metal`, where it is given.
    pub metal: Option<Complex64>,
    /// Value of `--wavelength-nm`, the wavelength in vacuum, nm, where it is given.
    pub wavelength_nm: Option<f64>,
    /// Value of `--method`.
    pub method: Method,
    /// Value of `--sampler`.
    pub sampler: Sampler,
    /// Value of `--rays`, rays per direction, where it is given.
    pub rays: Option<u64>,
    /// Value of `--tolerance`, the largest L1 error of eta x histogram, where it is given.
    pub tolerance: Option<f64>,
    /// Value of `--bins`: bins along each axis of the histogram.
    pub bins: usize,
    /// Value of `--range`: half the width of the histogram, edge lengths.
    pub range: f64,
    /// Value of `--angular-tolerance`, degrees.
    pub angular_tolerance_deg: f64,
    /// Value of `--seed`.
    pub seed: u64,
    /// Value of `--threads`, where it is given.
    pub threads: Option<usize>,
    /// Text of `--shard`, such as `2/8`, where it is given.
    pub shard: Option<String>,
    /// Value of `--direction-tolerance`, a total variation, where it is given.
    pub direction_tolerance: Option<f64>,
    /// Options that only some scenes have.
    pub scene: SceneOptions,
}

impl Default for Request {
    fn default() -> Self {
        Request {
            incidence: default::INCIDENCE.into(),
            azimuth: default::AZIMUTH.into(),
            refractive_index: None,
            back: Back::Mirror,
            losses: Losses::None,
            reflectance: None,
            metal: None,
            wavelength_nm: None,
            method: Method::Auto,
            sampler: Sampler::Sobol,
            rays: None,
            tolerance: None,
            bins: default::BINS,
            range: default::RANGE,
            angular_tolerance_deg: default::ANGULAR_TOLERANCE_DEG,
            seed: default::SEED,
            threads: None,
            shard: None,
            direction_tolerance: None,
            scene: SceneOptions::default(),
        }
    }
}
