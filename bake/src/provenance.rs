//! What a table says about where it comes from.

use crate::plan::{Effort, Plan, Shard};
use meshes::Cell;
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
        losses: "none".into(),
        reflectance: 1.0,
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
        shards: match (plan.shard, plan.effort) {
            (Some(Shard { number, of }), Effort::Rays(rays)) => Some(Shards {
                of,
                rays,
                held: [number].into(),
            }),
            _ => None,
        },
        symmetry: plan.symmetry,
    }
}
