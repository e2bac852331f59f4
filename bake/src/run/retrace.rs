//! A table judged by its mesh: a random part of its directions traced again.

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

/// Incidences and azimuths that are traced again, at most.
const PART: [usize; 2] = [4, 2];

/// Why a table cannot be judged by a mesh.
#[derive(Debug, Error)]
pub enum RetraceError {
    /// It was baked with options of a later version.
    #[error("the table was baked with options that are not known to this version; update it")]
    Unknown,
    /// It says of other azimuths what the mesh does not do.
    #[error("the table claims a symmetry that the mesh does not have; bake it again")]
    Symmetry,
    /// The rays failed.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// Traces `rays` rays at some directions of `table` through the cell, chosen by `seed`, and
/// compares them with it. Whatever the table was baked by, these rays are independent random
/// points, whose counting error is known.
///
/// # Errors
/// [`RetraceError`].
pub fn retrace(
    table: &Table,
    prepared: &Prepared,
    rays: u64,
    seed: u64,
    watch: Watch<'_>,
) -> Result<Comparison, RetraceError> {
    let from = &table.provenance;
    let Stated {
        back,
        losses,
        scene,
    } = stated(from).ok_or(RetraceError::Unknown)?;
    if from.symmetry != Symmetry::NONE && from.symmetry != prepared.symmetry() {
        return Err(RetraceError::Symmetry);
    }
    let axes = &table.axes;
    let incidences = some(axes.incidence_deg.len(), PART[0], seed);
    let azimuths = some(axes.azimuth_deg.len(), PART[1], seed);
    let part = table.part(&incidences, &azimuths);
    let plan = Plan {
        axes: part.axes.clone(),
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
    };
    let traced = trace(prepared, &plan, watch)?;
    Ok(Comparison::of(&part, &traced))
}

/// Up to `most` of the indices below `count`, at random, ascending.
fn some(count: usize, most: usize, seed: u64) -> Vec<usize> {
    let stream = Stream::new(Sampler::Random, seed, 0.0, 0.0, 0);
    let mut indices: Vec<usize> = (0..count).collect();
    indices.sort_by_key(|&index| stream.pair(index as u64));
    indices.truncate(most);
    indices.sort_unstable();
    indices
}
