//! Check of a table against its mesh: some of its directions, chosen at random, are traced again.

use crate::cell::Prepared;
use crate::plan::{Effort, Plan};
use crate::run::comparison::Comparison;
use crate::run::error::RunError;
use crate::run::provenance::{Stated, stated};
use crate::run::trace::trace;
use crate::run::watch::Watch;
use crate::samples::Stream;
use tables::options::{Method, Sampler};
use tables::{Symmetry, Table};
use thiserror::Error;

/// Largest number of incidences and of azimuths that are traced again.
const PART: [usize; 2] = [4, 2];

/// Reason why a table cannot be checked against a mesh.
#[derive(Debug, Error)]
pub enum RetraceError {
    /// Table that was baked with options of a later version.
    #[error(
        "the table was baked with options that this version of bake does not know; install a \
        newer version"
    )]
    Unknown,
    /// Table with a symmetry that the mesh does not have.
    #[error("the table claims a symmetry that the mesh does not have; bake it again")]
    Symmetry,
    /// Failure while the rays were traced.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// Checks a table against its mesh by rays, and returns the comparison.
///
/// Some directions of `table` are chosen by `seed`, and `rays` rays are traced through the cell in
/// each of them. These rays are independent random points, whatever the table was baked by, so
/// their counting error is known.
///
/// # Errors
/// Returns [`RetraceError::Unknown`] if the table was baked with options that this version does not
/// know, [`RetraceError::Symmetry`] if the table has a symmetry that the mesh does not have, and
/// [`RetraceError::Run`] if the rays cannot be traced or `watch` stopped them.
pub fn retrace(
    table: &Table,
    prepared: &Prepared,
    rays: u64,
    seed: u64,
    watch: Watch<'_>,
) -> Result<Comparison, RetraceError> {
    let axes = &table.axes;
    let incidences = some(axes.incidence_deg.len(), PART[0], seed);
    let azimuths = some(axes.azimuth_deg.len(), PART[1], seed);
    let part = table.part(&incidences, &azimuths);
    let traced = trace(prepared, &again(&part, prepared, rays, seed)?, watch)?;
    Ok(Comparison::of(&part, &traced))
}

/// Makes the exact bake of a table again, in all its directions, and returns the comparison, path
/// by path.
///
/// Returns `None` if the table has no polygons, or is a mean over azimuths.
///
/// # Errors
/// Returns the errors of [`retrace`], and [`RetraceError::Run`] if the exact method does not take
/// the cell.
pub fn rebake(
    table: &Table,
    prepared: &Prepared,
    watch: Watch<'_>,
) -> Result<Option<Comparison>, RetraceError> {
    if table.exact.is_none() || table.axes.is_mean() {
        return Ok(None);
    }
    let plan = Plan {
        method: Method::Exact,
        ..again(table, prepared, 1, 0)?
    };
    let baked = trace(prepared, &plan, watch)?;
    Ok(Some(Comparison::of(table, &baked)))
}

/// Returns the plan of a bake by `rays` random rays in each direction of `table`, with its options.
fn again(table: &Table, prepared: &Prepared, rays: u64, seed: u64) -> Result<Plan, RetraceError> {
    let from = &table.provenance;
    let Stated {
        back,
        losses,
        scene,
    } = stated(from).ok_or(RetraceError::Unknown)?;
    if from.symmetry != Symmetry::NONE && from.symmetry != prepared.symmetry() {
        return Err(RetraceError::Symmetry);
    }
    Ok(Plan {
        axes: table.axes.clone(),
        full_step_deg: None,
        direction_tolerance: None,
        refractive_index: Some(from.refractive_index),
        back,
        losses,
        wavelength_nm: from.wavelength_nm,
        method: Method::Rays,
        sampler: Sampler::Random,
        effort: Effort::Rays(rays),
        randomisations: 1,
        angular_tolerance_deg: from.angular_tolerance_deg,
        seed,
        threads: None,
        shard: None,
        scene,
    })
}

/// Returns up to `most` of the indices below `count`, chosen at random, ascending.
fn some(count: usize, most: usize, seed: u64) -> Vec<usize> {
    let stream = Stream::new(Sampler::Random, seed, 0.0, 0.0, 0);
    let mut indices: Vec<usize> = (0..count).collect();
    indices.sort_by_key(|&index| stream.pair(index as u64));
    indices.truncate(most);
    indices.sort_unstable();
    indices
}
