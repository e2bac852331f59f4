//! Where a table comes from.

use crate::options::{Back, Element, Losses, Method, Sampler, StatedOptions, Word};
use crate::table::shards::Shards;
use crate::table::symmetry::Symmetry;

/// What a bake writes as the generator of its tables.
///
/// It names how options become numbers, not the program or its version: it rises when the same
/// options give other numbers, so that tables of two versions of a program add up as long as their
/// rays are of one kind.
pub const GENERATOR: &str = "airr ray-shift table 1";

/// What programs before this name wrote for the same numbers.
const EARLIER: [&str; 1] = ["bake 0.1.0"];

/// The word of a file for no sampler.
const NO_SAMPLER: &str = "none";

/// The name that a generator has now.
pub(crate) fn level(generator: &str) -> &str {
    match EARLIER.contains(&generator) {
        true => GENERATOR,
        false => generator,
    }
}

/// The sampler of a file's word.
pub(crate) fn sampler(text: String) -> Option<Word<Sampler>> {
    (text != NO_SAMPLER).then(|| Word::read(text))
}

/// Where a table comes from: all that is needed to bake it again.
#[derive(Debug, Clone, PartialEq)]
pub struct Provenance {
    /// What the numbers mean, [`GENERATOR`] of every bake of this version.
    pub generator: String,
    /// Name of the cell's design.
    pub design: String,
    /// SHA-256 of the mesh, lower-case hex.
    pub mesh_hash: String,
    /// Length of one edge in file units.
    pub edge_length: f64,
    /// Unit of `edge_length`; "file unit" where the file names none.
    pub edge_length_unit: String,
    /// First edge (azimuth 0) in the file's frame.
    pub azimuth_zero: [f64; 3],
    /// Refractive index behind the flat front face; 1 where there is none.
    pub refractive_index: f64,
    /// What the facets are backed with.
    pub back: Word<Back>,
    /// What surfaces take from the light.
    pub losses: Word<Losses>,
    /// Reflectance of each mirror facet, 1 where losses are left out or a metal or a bare back
    /// decides.
    pub reflectance: f64,
    /// How the distribution was found: [`Method::Rays`] or [`Method::Exact`].
    pub method: Word<Method>,
    /// How samples were spread; `None` for the exact method.
    pub sampler: Option<Word<Sampler>>,
    /// Seed of the samples.
    pub seed: u64,
    /// Largest deviation of the path's linear map from -I that counts as retroreflected, degrees.
    pub angular_tolerance_deg: f64,
    /// L1 error asked for, 0 where a number of rays was.
    pub tolerance: f64,
    /// Lattice vectors in the cell frame, edge lengths, where the cell is periodic.
    pub lattice: Option<[[f64; 2]; 2]>,
    /// Vacuum wavelength that the bake was told, nm; `None` where it was not.
    pub wavelength_nm: Option<f64>,
    /// Complex refractive index n + ik, as [n, k], of the metal behind each facet, where there is
    /// one.
    pub metal_index: Option<[f64; 2]>,
    /// Which shards of a bake these are; `None` for a whole one.
    pub shards: Option<Shards>,
    /// What the azimuths stand for besides themselves.
    pub symmetry: Symmetry,
    /// Total variation of eta x histogram that interpolated polygons are within, where the
    /// directions were chosen for it.
    pub direction_tolerance: Option<f64>,
    /// What else the rays obeyed.
    pub options: StatedOptions,
}

impl Provenance {
    /// What the mesh does with light.
    pub fn element(&self) -> Element {
        self.options.element()
    }

    /// Whether light went through bodies of glass.
    pub fn has_glass(&self) -> bool {
        self.options.has_glass()
    }

    /// How samples were spread, in the word of the file: `none` for the exact method.
    pub fn sampler_text(&self) -> &str {
        self.sampler.as_ref().map_or(NO_SAMPLER, Word::text)
    }

    /// Whether the samples are plain random ones, whose rays are independent.
    pub fn is_random(&self) -> bool {
        let sampler = self.sampler.as_ref();
        sampler.is_some_and(|sampler| sampler.is(Sampler::Random))
    }

    /// What the surfaces take from the light, in words: `none`, or `fresnel` and what the facets
    /// are made of.
    pub fn losses_text(&self) -> String {
        match self.metal_index {
            _ if self.losses.is(Losses::None) => self.losses.to_string(),
            Some([n, k]) => format!("{}, metal of index {n} + {k}i", self.losses),
            None if self.back.is(Back::Mirror) => {
                format!(
                    "{}, mirrors of reflectance {}",
                    self.losses, self.reflectance
                )
            }
            None => format!("{}, bare facets", self.losses),
        }
    }

    /// Whether this is the provenance of the same bake: equal, but that an earlier program may have
    /// named the generator.
    pub fn is_of_the_bake(&self, other: &Provenance) -> bool {
        let named = |from: &Provenance| Provenance {
            generator: level(&from.generator).to_owned(),
            ..from.clone()
        };
        named(self) == named(other)
    }
}
