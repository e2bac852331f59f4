//! The plan of a bake, made from the options as typed.

use crate::cell::{ExactCell, NO_PLANES, Prepared, Whole};
use crate::error::Error;
use crate::optics::{Backing, Rules, roughness};
use crate::plan::directions::{angles, direction_tolerance, full_step, sector};
use crate::plan::effort;
use crate::plan::effort::{BINS_LIMIT, MOST_BYTES};
use crate::plan::effort::{Effort, Shard};
use crate::plan::effort::{count, number, positive};
use crate::plan::losses::{self, no_planes};
use crate::plan::request::Request;
use std::num::NonZeroUsize;
use tables::options::{Back, Element, Front, Method, Sampler, SceneOptions};
use tables::{Axes, MOST_DIRECTIONS, Symmetry};

/// Checked plan of a bake, in which nothing is out of range.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Directions and bins of the table; an azimuth of NaN stands for the mean over all azimuths.
    pub(crate) axes: Axes,
    /// Widest step between azimuths, degrees, where all azimuths are asked for; see
    /// [`Plan::folded`].
    pub(crate) full_step_deg: Option<f64>,
    /// Largest error between directions, a total variation, where directions are chosen for it.
    ///
    /// They are chosen when the plan meets its cell.
    pub(crate) direction_tolerance: Option<f64>,
    /// Refractive index that was asked for; `None` stands for that of the cell.
    pub(crate) refractive_index: Option<f64>,
    /// Back of the facets: a mirror, or total internal reflection alone.
    pub(crate) back: Back,
    /// Material behind the facets; `None` where losses are not counted.
    pub(crate) losses: Option<Backing>,
    /// Wavelength in vacuum, nm, where it was given.
    pub(crate) wavelength_nm: Option<f64>,
    /// Method of the bake: exact, by rays, or whichever fits.
    pub(crate) method: Method,
    /// Sampler that spreads the samples.
    pub(crate) sampler: Sampler,
    /// Amount of work for each direction.
    pub(crate) effort: Effort,
    /// Number of independent randomisations per direction.
    pub(crate) randomisations: usize,
    /// Largest rotation from the exact way back that counts as retroreflected, degrees.
    pub(crate) angular_tolerance_deg: f64,
    /// Seed of the samples.
    pub(crate) seed: u64,
    /// Number of threads; `None` stands for all processors.
    pub(crate) threads: Option<NonZeroUsize>,
    /// Part of the samples to trace; `None` stands for all samples.
    pub(crate) shard: Option<Shard>,
    /// Options that only some scenes have.
    pub(crate) scene: SceneOptions,
}

impl Plan {
    /// Checks a request and makes the plan of it.
    ///
    /// # Errors
    /// Returns [`Error::Usage`] for the first option that is out of range or cannot be read, or for
    /// two options that exclude each other.
    pub fn new(request: &Request) -> Result<Self, Error> {
        let (axes, full_step_deg) = asked(request)?;
        numbers(request)?;
        let losses = losses::surface(request)?;
        losses::glass(request)?;
        if request.scene.front == Front::Trapped && request.scene.element == Element::Plate {
            return Err(Error::both("--front trapped", "--element plate"));
        }
        let effort = Effort::of(request)?;
        let threads = effort::threads(request)?;
        let shard = effort::shard(request)?;
        Ok(Plan {
            axes,
            full_step_deg,
            direction_tolerance: direction_tolerance(request)?,
            refractive_index: request.refractive_index,
            back: request.back,
            losses,
            wavelength_nm: request.wavelength_nm,
            method: request.method,
            sampler: request.sampler,
            effort,
            randomisations: effort.randomisations(request.sampler),
            angular_tolerance_deg: request.angular_tolerance_deg,
            seed: request.seed,
            threads,
            shard,
            scene: request.scene,
        })
    }

    /// Returns the directions and bins for a cell, and the symmetry by which its azimuths stand for
    /// others.
    ///
    /// If all azimuths are asked for, the directions have only the azimuths of one sector; the
    /// symmetry of the cell gives the rest. Otherwise the azimuths stand for themselves alone.
    pub(crate) fn folded(&self, prepared: &Prepared) -> (Axes, Symmetry) {
        let axes = self.axes.clone();
        let Some(step) = self.full_step_deg else {
            return (axes, Symmetry::NONE);
        };
        let symmetry = prepared.symmetry();
        let azimuth_deg = sector(symmetry, step);
        let axes = Axes {
            azimuth_deg,
            ..axes
        };
        (axes, symmetry)
    }

    /// Returns the cell in the form that the exact method needs.
    ///
    /// # Errors
    /// Returns why the exact method cannot bake the cell under these options.
    pub(crate) fn exact_cell<'a>(&self, prepared: &'a Prepared) -> Result<&'a ExactCell, String> {
        match no_planes(&self.scene) {
            Some(option) => Err(format!("{option} {NO_PLANES}")),
            None if self.is_azimuth_mean() && self.deviations(prepared).is_some() => Err(
                "the cell sends light off the exact way back, and an exact mean over azimuths \
                cannot store where this light goes; give --method rays, or --deviations off to \
                leave it out"
                    .into(),
            ),
            None => prepared.exact().map_err(String::from),
        }
    }

    /// Returns whether the table is a mean over all azimuths.
    pub(crate) fn is_azimuth_mean(&self) -> bool {
        self.axes.azimuth_deg[..]
            .first()
            .is_some_and(|azimuth| azimuth.is_nan())
    }

    /// Returns the refractive index behind the front face of `cell`.
    ///
    /// An index that was asked for comes first, then that of the mesh file. Without either, it is
    /// 1.
    pub(crate) fn index_of(&self, cell: &meshes::Cell) -> f64 {
        self.refractive_index
            .or(cell.refractive_index_at(self.wavelength_nm))
            .unwrap_or(1.0)
    }

    /// Returns the rules by which the facets of `cell` change light.
    pub(crate) fn rules(&self, cell: &meshes::Cell) -> Rules {
        Rules {
            refractive_index: self.index_of(cell),
            mirror_back: self.back == Back::Mirror,
            losses: self.losses,
            angular_tolerance_rad: self.angular_tolerance_deg.to_radians(),
            roughness: self.scene.roughness,
            element: self.scene.element,
            glass_index: self.scene.glass_index,
            front: self.scene.front,
        }
    }

    /// Returns the warnings about this plan on the cell, for the user.
    ///
    /// They name options that contradict each other without being wrong, and meshes that make the
    /// bake slower than necessary.
    pub fn warnings(&self, prepared: &Prepared) -> Vec<String> {
        let cell = prepared.cell();
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
                "--back tir without a refractive index above 1: nothing is totally reflected, so \
                that nothing returns; give --refractive-index"
                    .into(),
            );
        }
        warnings.extend(self.index_left_out(cell));
        if self.scene.front == Front::Trapped && self.index_of(cell) <= 1.0 {
            warnings.push(
                "--front trapped has no effect without a front face; give --refractive-index, or \
                leave it out"
                    .into(),
            );
        }
        let tolerance_deg = self.angular_tolerance_deg;
        let beyond = self.scene.roughness.map_or(0.0, |rough| {
            roughness::part_beyond(&rough, tolerance_deg.to_radians())
        });
        if beyond > 0.01 {
            warnings.push(format!(
                "--roughness turns about {:.0} % of the light that three facets send back by more \
                than --angular-tolerance {tolerance_deg} deg; this light does not count as \
                retroreflected",
                100.0 * beyond
            ));
        }
        if let Err(reason @ (Whole::Connected | Whole::Unlike)) = prepared.kinds() {
            warnings.push(format!(
                "the mesh is traced as a whole, not one cube of each kind: {reason}; if it is a \
                sheet of equal cubes, give one period of it"
            ));
        }
        warnings
    }

    /// Returns a remark if neither the user nor the mesh says what is behind the front face.
    ///
    /// A plate, bodies of glass and bare facets are left out: the index of the first two is not
    /// that of a front face, and bare facets have a warning of their own.
    fn index_left_out(&self, cell: &meshes::Cell) -> Option<String> {
        let own = cell.refractive_index_at(self.wavelength_nm);
        let behind_a_front = self.scene.element == Element::Retroreflector
            && self.scene.glass_index.is_none()
            && self.back == Back::Mirror;
        (behind_a_front && self.refractive_index.or(own).is_none()).then(|| INDEX_LEFT_OUT.into())
    }
}

/// Remark on an index that neither the user nor the mesh states.
pub(crate) const INDEX_LEFT_OUT: &str = "--refractive-index was left out: the cubes are taken as \
    hollow (index 1); give the index of the material behind the front face, such as 1.49 for \
    acrylic, or say --refractive-index 1";

/// Reads directions and bins, and the step between azimuths if all azimuths are asked for.
fn asked(request: &Request) -> Result<(Axes, Option<f64>), Error> {
    let incidence_deg = angles("--incidence", &request.incidence)?;
    within(
        "--incidence",
        &incidence_deg,
        |angle| (0.0..90.0).contains(&angle),
        "from 0 to below 90 degrees",
    )?;
    let full_step_deg = full_step(&request.azimuth)?;
    let azimuth_deg = match request.azimuth.trim() {
        "mean" => vec![f64::NAN],
        _ if let Some(step) = full_step_deg => sector(Symmetry::NONE, step),
        text => angles("--azimuth", text)?,
    };
    within(
        "--azimuth",
        &azimuth_deg,
        |angle| angle.is_nan() || angle.abs() <= 360.0,
        "from -360 to 360 degrees",
    )?;
    let directions = incidence_deg.len() * azimuth_deg.len();
    if directions > MOST_DIRECTIONS {
        return Err(Error::Usage(format!(
            "--incidence and --azimuth make {directions} directions; a table holds at most \
            {MOST_DIRECTIONS}: give fewer angles"
        )));
    }
    // Rays are counted in each of their randomisations. The exact method has the histogram alone.
    let copies = match request.method {
        Method::Rays => Effort::of(request)?.randomisations(request.sampler),
        Method::Exact | Method::Auto => 1,
    };
    let bytes = [request.bins, request.bins, directions, copies]
        .iter()
        .fold(8_u64, |product, &n| product.saturating_mul(n as u64));
    if bytes > MOST_BYTES {
        let bins = request.bins;
        return Err(Error::Usage(format!(
            "--bins {bins} in {directions} directions make arrays of {bytes} bytes; a table holds \
            at most {MOST_BYTES}: give fewer bins or fewer angles"
        )));
    }
    let axes = Axes {
        incidence_deg,
        azimuth_deg,
        bins: request.bins,
        range: request.range,
    };
    Ok((axes, full_step_deg))
}

/// Checks that all `angles` are within the range that `range` states in words.
fn within(
    option: &str,
    angles: &[f64],
    is_within: impl Fn(f64) -> bool,
    range: &str,
) -> Result<(), Error> {
    match angles.iter().find(|&&angle| !is_within(angle)) {
        Some(angle) => Err(Error::Usage(format!(
            "{option} {angle}: the angle must be {range}"
        ))),
        None => Ok(()),
    }
}

/// Checks the numbers that can be checked without other options.
fn numbers(request: &Request) -> Result<(), Error> {
    count("--bins", request.bins as u64, BINS_LIMIT as u64)?;
    let range = "above 0 and at most 1e5 edge lengths";
    positive("--range", request.range, 1e5, range)?;
    // The tolerance is for small rotations from straight back. A path of two reflections is no
    // small rotation.
    let range = "above 0 and at most 10 degrees";
    let tolerance_deg = request.angular_tolerance_deg;
    positive("--angular-tolerance", tolerance_deg, 10.0, range)?;
    if let Some(index) = request.refractive_index {
        let allowed = (1.0..=10.0).contains(&index);
        number("--refractive-index", index, allowed, "from 1 to 10")?;
    }
    match request.wavelength_nm {
        Some(nm) => positive("--wavelength-nm", nm, 1e6, "above 0 and at most 1e6 nm"),
        None => Ok(()),
    }
}
