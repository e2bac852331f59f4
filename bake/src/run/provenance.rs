//! What a table says about where it comes from.

use crate::optics::light::Surface;
use crate::plan::plan::{Back, Effort, Plan, Shard};
use meshes::Cell;
use num_complex::Complex64;
use tables::{Provenance, Shards};

/// Where a table of `cell` baked by `method` comes from.
pub fn provenance(cell: &Cell, plan: &Plan, method: String, sampler: String) -> Provenance {
    Provenance {
        generator: concat!("bake ", env!("CARGO_PKG_VERSION")).into(),
        design: cell.design.clone(),
        mesh_hash: cell.mesh_hash.clone(),
        edge_length: cell.edge_length,
        edge_length_unit: "file unit".into(),
        azimuth_zero: cell.azimuth_zero.to_array(),
        refractive_index: plan.index_of(cell),
        back: plan.back.name().into(),
        losses: plan.losses.map_or("none", |_| "fresnel").into(),
        reflectance: match plan.losses {
            Some(Surface::Mirror { reflectance }) => reflectance,
            _ => 1.0,
        },
        method,
        sampler,
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
        options: plan.scene.to_string(),
    }
}

/// What was behind the facets of a table whose losses count; `None` where they do not.
///
/// # Errors
/// The table names losses or a back that this program does not know.
pub fn losses_of(from: &Provenance) -> Result<Option<Surface>, Unknown> {
    let reflectance = from.reflectance;
    match (from.losses.as_str(), Back::from_name(&from.back)) {
        (_, None) => Err(Unknown),
        ("none", _) => Ok(None),
        ("fresnel", Some(Back::Tir)) => Ok(Some(Surface::Bare)),
        ("fresnel", Some(Back::Mirror)) => Ok(Some(match from.metal_index {
            Some([n, k]) => Surface::Metal(Complex64::new(n, k)),
            None => Surface::Mirror { reflectance },
        })),
        _ => Err(Unknown),
    }
}

/// Losses of a later version.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unknown;
