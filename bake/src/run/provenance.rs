//! What a table says about where it comes from.

use crate::optics::light::Surface;
use crate::plan::plan::{Back, Effort, Losses, Method, Plan, Shard};
use meshes::Cell;
use num_complex::Complex64;
use tables::options::{Sampler, Word};
use tables::{Provenance, Shards};

/// Where a table of `cell` baked by `method` comes from.
pub fn provenance(
    cell: &Cell,
    plan: &Plan,
    method: Method,
    sampler: Option<Sampler>,
) -> Provenance {
    Provenance {
        generator: tables::GENERATOR.into(),
        design: cell.design.clone(),
        mesh_hash: cell.mesh_hash.clone(),
        edge_length: cell.edge_length,
        edge_length_unit: "file unit".into(),
        azimuth_zero: cell.azimuth_zero.to_array(),
        refractive_index: plan.index_of(cell),
        back: plan.back.into(),
        losses: plan.losses.map_or(Losses::None, |_| Losses::Fresnel).into(),
        reflectance: match plan.losses {
            Some(Surface::Mirror { reflectance }) => reflectance,
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
            Some(Surface::Metal(index)) => Some([index.re, index.im]),
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
        symmetry: plan.symmetry,
        direction_tolerance: plan.direction_tolerance,
        options: plan.scene.into(),
    }
}

/// What was behind the facets of a table whose losses count; `None` where they do not.
///
/// # Errors
/// The table names losses or a back that this program does not know.
pub fn losses_of(from: &Provenance) -> Result<Option<Surface>, Unknown> {
    let reflectance = from.reflectance;
    let (losses, back) = from.losses.known().zip(from.back.known()).ok_or(Unknown)?;
    Ok(match (losses, back, from.metal_index) {
        (Losses::None, ..) => None,
        (Losses::Fresnel, Back::Tir, _) => Some(Surface::Bare),
        (Losses::Fresnel, Back::Mirror, Some([n, k])) => Some(Surface::Metal(Complex64::new(n, k))),
        (Losses::Fresnel, Back::Mirror, None) => Some(Surface::Mirror { reflectance }),
    })
}

/// Losses of a later version.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unknown;
