//! Origin of a table.

use crate::options::{Back, Element, Losses, Method, Sampler, StatedOptions, Word};
use crate::table::fate::Fate;
use crate::table::shards::Shards;
use crate::table::symmetry::Symmetry;

/// Generator that a bake writes into its tables.
///
/// It names the rule by which options become numbers, not the program or its version. It changes
/// when equal options give other numbers. So tables of two versions of a program can be merged as
/// long as their rays are of one kind.
///
/// Tables of rough facets have [`GENERATOR_OF_ROUGH`], those of a refractive index above 1
/// [`GENERATOR_BEHIND_FRONT`], and those of such an index with losses [`GENERATOR_OF_LOSSY_FRONT`].
pub const GENERATOR: &str = "airr ray-shift table 1";

/// Generator that a bake writes into tables of rough facets.
///
/// Programs before 24 November 2026 drew other normals for them, and wrote [`GENERATOR`].
pub const GENERATOR_OF_ROUGH: &str = "airr ray-shift table 2";

/// Generator that a bake writes into tables of a refractive index above 1, rough or not.
///
/// Programs before 27 November 2026 took the angle of light that leaves straight back by another
/// map inside the sheet, and wrote [`GENERATOR`] or [`GENERATOR_OF_ROUGH`].
pub const GENERATOR_BEHIND_FRONT: &str = "airr ray-shift table 3";

/// Generator that a bake writes into tables of a refractive index above 1 with losses.
///
/// Programs before 28 November 2026 counted light that the front face reflects as absorbed, and
/// wrote the other generators.
pub const GENERATOR_OF_LOSSY_FRONT: &str = "airr ray-shift table 4";

/// Generators of earlier programs that give the numbers of [`GENERATOR`].
const EARLIER: [&str; 1] = ["bake 0.1.0"];

/// Word of the file for no sampler.
const NO_SAMPLER: &str = "none";

/// Returns the present name of a generator.
pub(crate) fn level(generator: &str) -> &str {
    match EARLIER.contains(&generator) {
        true => GENERATOR,
        false => generator,
    }
}

/// Returns the sampler that a word of the file names.
pub(crate) fn sampler(text: String) -> Option<Word<Sampler>> {
    (text != NO_SAMPLER).then(|| Word::read(text))
}

/// Origin of a table: all that is needed to bake it again.
#[derive(Debug, Clone, PartialEq)]
pub struct Provenance {
    /// Rule that made the numbers; in bakes of this version [`GENERATOR`],
    /// [`GENERATOR_OF_ROUGH`], [`GENERATOR_BEHIND_FRONT`] or [`GENERATOR_OF_LOSSY_FRONT`].
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
    /// Material behind the facets.
    pub back: Word<Back>,
    /// Losses at the surfaces.
    pub losses: Word<Losses>,
    /// Reflectance of each mirror facet; 1 without losses, and where a metal or a bare back
    /// decides.
    pub reflectance: f64,
    /// Method that found the distribution: [`Method::Rays`] or [`Method::Exact`].
    pub method: Word<Method>,
    /// Sampler of the points of entry; `None` for the exact method.
    pub sampler: Option<Word<Sampler>>,
    /// Seed of the samples.
    pub seed: u64,
    /// Largest deviation of the path's linear map from -I that counts as retroreflected, degrees.
    pub angular_tolerance_deg: f64,
    /// L1 error that the user asked for; 0 where the user asked for a number of rays.
    pub tolerance: f64,
    /// Lattice vectors in the cell frame, edge lengths; `None` unless the cell is periodic.
    pub lattice: Option<[[f64; 2]; 2]>,
    /// Vacuum wavelength that the user stated, nm; `None` without one.
    pub wavelength_nm: Option<f64>,
    /// Complex refractive index n + ik, as [n, k], of the metal behind each facet; `None` without
    /// metal.
    pub metal_index: Option<[f64; 2]>,
    /// Shards of a bake that the table holds; `None` for a whole bake.
    pub shards: Option<Shards>,
    /// Symmetry by which the azimuths of the table stand for others.
    pub symmetry: Symmetry,
    /// Bound of the total variation of eta x histogram between interpolated and true polygons.
    ///
    /// `None` unless the directions were chosen for such a bound.
    pub direction_tolerance: Option<f64>,
    /// Further options that the rays obeyed.
    pub options: StatedOptions,
}

impl Provenance {
    /// Returns the optical element that the mesh is.
    pub fn element(&self) -> Element {
        self.options.element()
    }

    /// Returns whether light went through bodies of glass.
    pub fn has_glass(&self) -> bool {
        self.options.has_glass()
    }

    /// Returns the name of the sampler in the file: `none` for the exact method.
    pub fn sampler_text(&self) -> &str {
        self.sampler.as_ref().map_or(NO_SAMPLER, Word::text)
    }

    /// Returns whether the samples are plain random ones, whose rays are independent.
    pub fn is_random(&self) -> bool {
        let sampler = self.sampler.as_ref();
        sampler.is_some_and(|sampler| sampler.is(Sampler::Random))
    }

    /// Returns the losses at the surfaces in words: `none`, or `fresnel` and the material of the
    /// facets.
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

    /// Returns the fates of a table that has `columns` of them, in the order of the file.
    ///
    /// Only tables whose front face reflects light have [`Fate::ReflectedByFront`], and older ones
    /// of them lack it. Any other number is none that such a table may have; the fates are then
    /// those that it should have.
    pub fn fates(&self, columns: usize) -> &'static [Fate] {
        let front = self.options.front();
        let older = Fate::of(front, false);
        let reflects = self.losses.is(Losses::Fresnel) && self.refractive_index > 1.0;
        match columns == older.len() {
            true => older,
            false => Fate::of(front, reflects),
        }
    }

    /// Returns whether `other` is the provenance of an equal bake.
    ///
    /// Both must be equal, but an earlier program may have named the generator.
    pub fn is_of_the_bake(&self, other: &Provenance) -> bool {
        let named = |from: &Provenance| Provenance {
            generator: level(&from.generator).to_owned(),
            ..from.clone()
        };
        named(self) == named(other)
    }
}
