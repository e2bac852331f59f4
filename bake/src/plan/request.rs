//! What is asked of a bake, as typed.

use crate::plan::default;
use num_complex::Complex64;
use tables::options::{Back, Losses, Method, Sampler, SceneOptions};

/// The options of `bake trace` that shape the table, as typed.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// `--incidence`
    pub incidence: String,
    /// `--azimuth`
    pub azimuth: String,
    /// `--refractive-index`, where given
    pub refractive_index: Option<f64>,
    /// `--back`
    pub back: Back,
    /// `--losses`
    pub losses: Losses,
    /// `--reflectance`, where given
    pub reflectance: Option<f64>,
    /// Index of `--metal`, where given
    pub metal: Option<Complex64>,
    /// `--wavelength-nm`, where given
    pub wavelength_nm: Option<f64>,
    /// `--method`
    pub method: Method,
    /// `--sampler`
    pub sampler: Sampler,
    /// `--rays`, where given
    pub rays: Option<u64>,
    /// `--tolerance`, where given
    pub tolerance: Option<f64>,
    /// `--bins`
    pub bins: usize,
    /// `--range`
    pub range: f64,
    /// `--angular-tolerance`, degrees
    pub angular_tolerance_deg: f64,
    /// `--seed`
    pub seed: u64,
    /// `--threads`, where given
    pub threads: Option<usize>,
    /// `--shard`, where given
    pub shard: Option<String>,
    /// `--direction-tolerance`, where given
    pub direction_tolerance: Option<f64>,
    /// Options of some scenes only
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
