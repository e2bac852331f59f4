//! Bakes of cells that are dissected for one question only.

use crate::cell::{ExactCell, Kind, Prepared, Whole};
use crate::error::Error;
use crate::geometry::Stream;
use crate::optics::Rules;
use crate::plan::{Plan, Request, default};
use crate::rays::{Accumulator, Bins, Kernel, Tracer};
use crate::run::{Bake, Progress, trace};
use meshes::Cell;
use std::ops::Range;
use tables::options::{Element, Front, Method};
use tables::{Symmetry, Table};

/// Returns the request of the options of a command line.
pub(crate) fn asked(line: &str) -> Request {
    let words: Vec<_> = line.split(' ').map(Into::into).collect();
    tables::cli::parsed(&words).expect("options of `bake trace`")
}

/// Bakes the table of a cell by the method that the plan names.
pub(crate) fn bake(cell: &Cell, plan: &Plan) -> Result<Table, Error> {
    trace(&prepared(cell), plan, Progress::none())
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
    Bake::new(&prepared, &plan, Progress::none())?
        .by(tracer)
        .table(Progress::none())
}

/// Traces `samples` as the kernel does and one by one; panics unless every count is the same.
#[track_caller]
pub(crate) fn compare(
    kernel: &Kernel,
    bins: &Bins,
    stream: &Stream,
    samples: Range<u64>,
) -> Accumulator {
    let (mut fast, mut plain) = (Accumulator::new(bins), Accumulator::new(bins));
    kernel.trace(stream, samples.clone(), &mut fast);
    kernel.trace_one_by_one(stream, samples.clone(), &mut plain);
    assert_eq!(fast.take_exits(), plain.take_exits());
    assert_eq!(fast.fates, plain.fates);
    // Behind the bins the kernel counts rays that fall in none.
    assert!(fast.histogram[..bins.len()] == plain.histogram[..bins.len()]);
    assert_eq!(fast.fates.iter().sum::<u64>(), samples.end - samples.start);
    fast
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
