//! A table judged by its mesh: a random part of its directions traced again.

use crate::cli::report::Comparison;
use crate::optics::light::Surface;
use crate::plan::plan::{Back, Effort, Method, Plan, SceneOptions};
use crate::run::run;
use crate::run::run::RunError;
use crate::samples::sequence::{Sampler, Stream};
use meshes::Cell;
use tables::Table;

/// Incidences and azimuths that are traced again, at most.
const PART: [usize; 2] = [4, 2];

/// Traces `rays` rays at some directions of `table`, chosen by `seed`, and compares them with it. Whatever the table was
/// baked by, these rays are independent random points, whose counting error is known.
///
/// # Errors
/// As [`run::rays`].
pub fn retrace(
    table: &Table,
    back: Back,
    losses: Option<Surface>,
    scene: SceneOptions,
    cell: &Cell,
    rays: u64,
    seed: u64,
) -> Result<Comparison, RunError> {
    let axes = &table.axes;
    let incidences = some(axes.incidence_deg.len(), PART[0], seed);
    let azimuths = some(axes.azimuth_deg.len(), PART[1], seed);
    let part = table.part(&incidences, &azimuths);
    let plan = Plan {
        axes: part.axes.clone(),
        full_step_deg: None,
        symmetry: table.provenance.symmetry,
        direction_tolerance: None,
        refractive_index: Some(table.provenance.refractive_index),
        back,
        losses,
        wavelength_nm: table.provenance.wavelength_nm,
        method: Method::Rays,
        sampler: Sampler::Random,
        effort: Effort::Rays(rays),
        randomisations: 1,
        angular_tolerance_deg: table.provenance.angular_tolerance_deg,
        seed,
        threads: None,
        shard: None,
        scene,
    };
    let traced = run::rays(cell, &plan, &|_| ())?;
    Ok(Comparison::new(&part, &traced).expect("axes equal themselves"))
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
