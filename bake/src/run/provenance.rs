//! Provenance of a table: the mesh, the options and the method that it was made with.

use crate::optics::Backing;
use crate::plan::{Effort, Plan, Shard};
use meshes::Cell;
use num_complex::Complex64;
use tables::options::{Back, Losses, Method, Sampler, SceneOptions, Word};
use tables::{Provenance, Shards, Symmetry};

/// Returns the provenance of a table of `cell` that is baked by `method`.
pub(crate) fn provenance(
    cell: &Cell,
    plan: &Plan,
    symmetry: Symmetry,
    method: Method,
    sampler: Option<Sampler>,
) -> Provenance {
    Provenance {
        generator: match plan.scene.roughness {
            _ if plan.index_of(cell) > 1.0 => match plan.losses {
                Some(_) => tables::GENERATOR_OF_LOSSY_FRONT,
                None => tables::GENERATOR_BEHIND_FRONT,
            },
            None => tables::GENERATOR,
            Some(_) => tables::GENERATOR_OF_ROUGH,
        }
        .into(),
        design: cell.design.clone(),
        mesh_hash: cell.mesh_hash.clone(),
        edge_length: cell.edge_length,
        edge_length_unit: cell.unit.clone().unwrap_or("file unit".into()),
        azimuth_zero: cell.azimuth_zero.to_array(),
        refractive_index: plan.index_of(cell),
        back: plan.back.into(),
        losses: plan.losses.map_or(Losses::None, |_| Losses::Fresnel).into(),
        reflectance: match plan.losses {
            Some(Backing::Mirror { reflectance }) => reflectance,
            _ => 1.0,
        },
        method: method.into(),
        sampler: sampler.map(Word::from),
        seed: plan.seed,
        angular_tolerance_deg: plan.angular_tolerance_deg,
        tolerance: match plan.effort {
            Effort::Tolerance(tolerance) => tolerance,
            Effort::Rays(_) => 0.0,
        },
        lattice: cell
            .entrance
            .lattice
            .map(|lattice| lattice.map(|vector| vector.to_array())),
        wavelength_nm: plan.wavelength_nm,
        metal_index: match plan.losses {
            Some(Backing::Metal(index)) => Some([index.re, index.im]),
            _ => None,
        },
        shards: match (plan.shard, plan.effort) {
            (Some(Shard { number, of }), Effort::Rays(rays)) => Some(Shards {
                of,
                rays,
                held: [number].into(),
            }),
            _ => None,
        },
        symmetry,
        direction_tolerance: plan.direction_tolerance,
        options: plan.scene.into(),
    }
}

/// Options that a table says its cell was baked with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stated {
    /// Back of the facets: a mirror, or total internal reflection alone.
    pub back: Back,
    /// Material behind the facets; `None` where losses were not counted.
    pub losses: Option<Backing>,
    /// Options that only some scenes have.
    pub scene: SceneOptions,
}

/// Reads the options of a table.
///
/// Returns `None` if the table names a back, losses or options that this program does not know.
pub(crate) fn stated(from: &Provenance) -> Option<Stated> {
    let back = from.back.known()?;
    let reflectance = from.reflectance;
    let losses = match (from.losses.known()?, back, from.metal_index) {
        (Losses::None, ..) => None,
        (Losses::Fresnel, Back::Tir, _) => Some(Backing::Bare),
        (Losses::Fresnel, Back::Mirror, Some([n, k])) => Some(Backing::Metal(Complex64::new(n, k))),
        (Losses::Fresnel, Back::Mirror, None) => Some(Backing::Mirror { reflectance }),
    };
    let scene = from.options.known()?;
    Some(Stated {
        back,
        losses,
        scene,
    })
}
