//! Bakes of cells that are dissected for one question only.

use crate::cell::{ExactCell, Kind, Prepared, Whole};
use crate::error::Error;
use crate::optics::Rules;
use crate::plan::{Plan, default};
use crate::rays::Tracer;
use crate::run::{Bake, Watch, trace};
use meshes::Cell;
use tables::options::Element;
use tables::options::Front;
use tables::options::Method;
use tables::{Symmetry, Table};

/// Bakes the table of a cell by the method that the plan names.
pub(crate) fn bake(cell: &Cell, plan: &Plan) -> Result<Table, Error> {
    trace(&prepared(cell), plan, Watch::none())
}

/// Bakes the table of a cell by rays, whatever method the plan names.
pub(crate) fn rays(cell: &Cell, plan: &Plan) -> Result<Table, Error> {
    rays_by(Tracer::Fastest, cell, plan)
}

/// Bakes the table of a cell by rays that `tracer` follows.
pub(crate) fn rays_by(tracer: Tracer, cell: &Cell, plan: &Plan) -> Result<Table, Error> {
    let plan = Plan {
        method: Method::Rays,
        ..plan.clone()
    };
    let prepared = prepared(cell);
    Bake::new(&prepared, &plan)?.by(tracer).table(Watch::none())
}

pub(crate) fn prepared(cell: &Cell) -> Prepared {
    Prepared::new(cell.clone())
}

/// Returns the cell in the form that the exact method takes.
pub(crate) fn exact(cell: &Cell) -> Result<ExactCell, String> {
    prepared(cell).exact().cloned().map_err(String::from)
}

pub(crate) fn kinds(cell: &Cell) -> Result<Vec<Kind>, Whole> {
    prepared(cell).kinds().map(<[Kind]>::to_vec)
}

pub(crate) fn symmetry(cell: &Cell) -> Symmetry {
    prepared(cell).symmetry()
}

impl Rules {
    /// Returns rules of perfect mirrors behind a flat front face of the given refractive index,
    /// with the usual tolerance. All other rules are options and left out.
    pub(crate) const fn mirrors(refractive_index: f64) -> Self {
        Rules {
            refractive_index,
            mirror_back: true,
            losses: None,
            angular_tolerance_rad: default::ANGULAR_TOLERANCE_DEG.to_radians(),
            roughness: None,
            element: Element::Retroreflector,
            glass_index: None,
            front: Front::Once,
        }
    }
}
