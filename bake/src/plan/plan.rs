//! From raw arguments to a checked plan. Every default of `bake trace` is stated here, once.

use crate::cell::bodies;
use crate::cell::bodies::Whole;
use crate::cell::symmetry;
use crate::optics::light::Surface;
use crate::optics::roughness;
use crate::plan::directions::{angles, direction_tolerance, full_step, sector};
use crate::plan::glass;
use crate::plan::losses;
use crate::rays::path::Rules;
use crate::samples::sequence::Sampler;
use std::num::NonZeroUsize;
use tables::MOST_SHARDS;
use tables::{Axes, Symmetry};

pub use crate::plan::error::PlanError;
pub use crate::plan::request::Request;
pub use tables::options::{Back, Losses, Method, NormalsFrom, Record, SceneOptions};

/// Rays of a direction in one randomisation at most: a scrambled sequence has that many distinct points.
pub const RAYS_PER_RANDOMISATION: u64 = 1 << 32;

/// Bins along an axis at most.
const BINS_LIMIT: usize = 4096;

/// Directions of a table at most.
pub(crate) const DIRECTIONS_LIMIT: usize = 100_000;

/// Defaults of `bake trace`, as a user types them.
pub mod default {
    /// `--incidence`
    pub const INCIDENCE: &str = "0:45:5";
    /// `--azimuth`
    pub const AZIMUTH: &str = "0";
    /// `--azimuth full` without a step, degrees
    pub const FULL_STEP_DEG: f64 = 5.0;
    /// `--rays` per direction
    pub const RAYS: u64 = 4_194_304;
    /// `--bins`
    pub const BINS: usize = 128;
    /// `--range`, edge lengths
    pub const RANGE: f64 = 2.0;
    /// `--angular-tolerance`, degrees
    pub const ANGULAR_TOLERANCE_DEG: f64 = 0.5;
    /// `--seed`
    pub const SEED: u64 = 1;
    /// Independent randomisations of a low-discrepancy sequence: enough for a standard error good to 18 %.
    pub const RANDOMISATIONS: u64 = 16;
    /// The same for `--tolerance`, which asks for the error of a histogram, a sum over thousands of bins. The error
    /// of N rays in all grows as R^(1/4): 1.6 times fewer rays reach it than with 16, at the price of a standard error
    /// of each eta that is good to 41 %.
    pub const RANDOMISATIONS_TO_TOLERANCE: u64 = 4;
}

/// How much work to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Effort {
    /// That many rays per direction.
    Rays(u64),
    /// Rays until the estimated L1 error of every direction is below this.
    Tolerance(f64),
}

/// A checked bake: nothing in it can be out of range.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Directions and bins; an azimuth of NaN stands for the mean over all.
    pub axes: Axes,
    /// The widest step between all azimuths, degrees, where all are asked for; see [`Plan::fold`].
    pub full_step_deg: Option<f64>,
    /// What the azimuths stand for besides themselves.
    pub symmetry: Symmetry,
    /// Between the directions that are chosen for it, total variation; see [`crate::run::directions::choose`].
    pub direction_tolerance: Option<f64>,
    /// Refractive index asked for; the cell's own where `None`.
    pub refractive_index: Option<f64>,
    /// What facets are backed with.
    pub back: Back,
    /// What is behind the facets where their losses count.
    pub losses: Option<Surface>,
    /// Vacuum wavelength, nm, where it was given.
    pub wavelength_nm: Option<f64>,
    /// How to bake.
    pub method: Method,
    /// How samples are spread.
    pub sampler: Sampler,
    /// How much work to do.
    pub effort: Effort,
    /// Independent randomisations per direction.
    pub randomisations: usize,
    /// Largest rotation that counts as retroreflected, degrees.
    pub angular_tolerance_deg: f64,
    /// Seed of the samples.
    pub seed: u64,
    /// Threads, all processors where `None`.
    pub threads: Option<NonZeroUsize>,
    /// The share of the samples to trace, all of them where `None`.
    pub shard: Option<Shard>,
    /// What only some scenes have.
    pub scene: SceneOptions,
}

/// An equal share of the samples of a bake.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Which one, from 1.
    pub number: u32,
    /// How many there are, at least 2.
    pub of: u32,
}

impl Plan {
    /// Checks a request.
    ///
    /// # Errors
    /// The first option that is out of range, or two that exclude each other.
    pub fn new(request: &Request) -> Result<Self, PlanError> {
        let incidence_deg = angles("--incidence", &request.incidence)?;
        if let Some(&value) = incidence_deg
            .iter()
            .find(|&&angle| !(0.0..90.0).contains(&angle))
        {
            return Err(PlanError::AngleRange {
                option: "--incidence",
                value,
                range: "from 0 to below 90 degrees",
            });
        }
        let full_step_deg = full_step(&request.azimuth)?;
        let azimuth_deg = match request.azimuth.trim() {
            "mean" => vec![f64::NAN],
            _ if let Some(step) = full_step_deg => sector(Symmetry::NONE, step),
            text => angles("--azimuth", text)?,
        };
        let turn = |angle: f64| angle > -360.0 && angle <= 360.0;
        if let Some(&value) = azimuth_deg
            .iter()
            .find(|&&angle| !angle.is_nan() && !turn(angle))
        {
            return Err(PlanError::AngleRange {
                option: "--azimuth",
                value,
                range: "above -360 and at most 360 degrees",
            });
        }
        let directions = incidence_deg.len() * azimuth_deg.len();
        if directions > DIRECTIONS_LIMIT {
            return Err(PlanError::Directions { directions });
        }
        count("--bins", request.bins as u64, BINS_LIMIT as u64)?;
        positive(
            "--range",
            request.range,
            1e5,
            "above 0 and at most 1e5 edge lengths",
        )?;
        positive(
            "--angular-tolerance",
            request.angular_tolerance_deg,
            // A path of two bounces is no small rotation from straight back.
            10.0,
            "above 0 and at most 10 degrees",
        )?;
        if let Some(value) = request
            .refractive_index
            .filter(|m| !(1.0..=10.0).contains(m))
        {
            return Err(PlanError::Number {
                option: "--refractive-index",
                value,
                range: "from 1 to 10",
            });
        }
        if let Some(nm) = request.wavelength_nm {
            positive("--wavelength-nm", nm, 1e6, "above 0 and at most 1e6 nm")?;
        }
        let losses = losses::surface(request)?;
        glass::check(request)?;
        let most = match request.sampler {
            Sampler::Sobol => RAYS_PER_RANDOMISATION * default::RANDOMISATIONS,
            Sampler::Random => 1 << 48,
        };
        let effort = match (request.rays, request.tolerance) {
            (Some(_), Some(_)) => {
                return Err(PlanError::Both {
                    first: "--rays",
                    second: "--tolerance",
                });
            }
            (_, Some(_)) if request.shard.is_some() => {
                return Err(PlanError::Both {
                    first: "--tolerance",
                    second: "--shard",
                });
            }
            (_, Some(_)) if request.sampler == Sampler::Random => {
                return Err(PlanError::ToleranceSampler);
            }
            (_, Some(tolerance)) => {
                positive(
                    "--tolerance",
                    tolerance,
                    2.0,
                    "above 0 and at most 2, the greatest L1 distance",
                )?;
                Effort::Tolerance(tolerance)
            }
            (rays, None) => {
                let rays = rays.unwrap_or(default::RAYS);
                count("--rays", rays, most)?;
                Effort::Rays(rays)
            }
        };
        let threads = request
            .threads
            .map(|threads| {
                let wrong = PlanError::Count {
                    option: "--threads",
                    value: threads as u64,
                    most: 4096,
                };
                NonZeroUsize::new(threads)
                    .filter(|threads| threads.get() <= 4096)
                    .ok_or(wrong)
            })
            .transpose()?;
        let shard = request.shard.as_deref().map(shard).transpose()?.flatten();
        let randomisations = match (request.sampler, effort) {
            (Sampler::Random, _) => 1,
            (Sampler::Sobol, Effort::Rays(rays)) => rays.min(default::RANDOMISATIONS) as usize,
            (Sampler::Sobol, Effort::Tolerance(_)) => default::RANDOMISATIONS_TO_TOLERANCE as usize,
        };
        Ok(Plan {
            axes: Axes {
                incidence_deg,
                azimuth_deg,
                bins: request.bins,
                range: request.range,
            },
            full_step_deg,
            symmetry: Symmetry::NONE,
            direction_tolerance: direction_tolerance(request)?,
            refractive_index: request.refractive_index,
            back: request.back,
            losses,
            wavelength_nm: request.wavelength_nm,
            method: request.method,
            sampler: request.sampler,
            effort,
            randomisations,
            angular_tolerance_deg: request.angular_tolerance_deg,
            seed: request.seed,
            threads,
            shard,
            scene: request.scene,
        })
    }

    /// Where all azimuths are asked for, only those of a sector that stands for all by the symmetry of `cell`.
    pub fn fold(self, cell: &meshes::Cell) -> Plan {
        let Some(step) = self.full_step_deg else {
            return self;
        };
        let symmetry = symmetry::of(cell);
        Plan {
            axes: Axes {
                azimuth_deg: sector(symmetry, step),
                ..self.axes
            },
            symmetry,
            ..self
        }
    }

    /// Whether the table is a mean over all azimuths.
    pub fn is_azimuth_mean(&self) -> bool {
        self.axes.azimuth_deg[..]
            .first()
            .is_some_and(|azimuth| azimuth.is_nan())
    }

    /// The refractive index behind the front face of `cell`: the one asked for, else the file's, else none.
    pub fn index_of(&self, cell: &meshes::Cell) -> f64 {
        self.refractive_index
            .or(cell.refractive_index_at(self.wavelength_nm))
            .unwrap_or(1.0)
    }

    /// What facets of `cell` do to light.
    pub fn rules(&self, cell: &meshes::Cell) -> Rules {
        Rules {
            refractive_index: self.index_of(cell),
            mirror_back: self.back == Back::Mirror,
            losses: self.losses,
            angular_tolerance_rad: self.angular_tolerance_deg.to_radians(),
            roughness: self.scene.roughness,
            element: self.scene.element,
            glass_index: self.scene.glass_index,
        }
    }

    /// What contradicts itself without being wrong, and what makes a bake slow that need not be, for the user.
    pub fn warnings(&self, cell: &meshes::Cell) -> Vec<String> {
        let mut warnings = Vec::new();
        if let (Some(asked), Some(own)) = (
            self.refractive_index,
            cell.refractive_index_at(self.wavelength_nm),
        ) && asked != own
        {
            warnings.push(format!(
                "--refractive-index {asked} overrides the {own} that the mesh file gives"
            ));
        }
        if self.back == Back::Tir && self.index_of(cell) <= 1.0 {
            warnings.push(
                "--back tir without a refractive index above 1: nothing is totally reflected, so that nothing returns; give \
                 --refractive-index"
                    .into(),
            );
        }
        let tolerance_deg = self.angular_tolerance_deg;
        let beyond = self.scene.roughness.map_or(0.0, |rough| {
            roughness::part_beyond(&rough, tolerance_deg.to_radians())
        });
        if beyond > 0.01 {
            warnings.push(format!(
                "--roughness turns about {:.0} % of what three facets send back by more than --angular-tolerance {tolerance_deg} \
                 deg: it does not count as retroreflected",
                100.0 * beyond
            ));
        }
        if let Err(reason @ (Whole::Connected | Whole::Unlike)) = bodies::kinds(cell) {
            warnings.push(format!(
                "the mesh is traced as a whole, not one cube of each kind: {reason}; if it is a sheet of equal cubes, \
                 give one period of it"
            ));
        }
        warnings
    }
}

/// Reads `2/8`; the only share of one is the whole bake.
fn shard(text: &str) -> Result<Option<Shard>, PlanError> {
    let wrong = || PlanError::Shard { text: text.into() };
    let number = |part: &str| part.trim().parse::<u32>().map_err(|_| wrong());
    let (k, n) = text.split_once('/').ok_or_else(wrong)?;
    let (k, n) = (number(k)?, number(n)?);
    if k < 1 || k > n || n > MOST_SHARDS {
        return Err(wrong());
    }
    Ok((n > 1).then_some(Shard { number: k, of: n }))
}

pub(crate) fn positive(
    option: &'static str,
    value: f64,
    most: f64,
    range: &'static str,
) -> Result<(), PlanError> {
    if value > 0.0 && value <= most {
        Ok(())
    } else {
        Err(PlanError::Number {
            option,
            value,
            range,
        })
    }
}

fn count(option: &'static str, value: u64, most: u64) -> Result<(), PlanError> {
    if (1..=most).contains(&value) {
        Ok(())
    } else {
        Err(PlanError::Count {
            option,
            value,
            most,
        })
    }
}
