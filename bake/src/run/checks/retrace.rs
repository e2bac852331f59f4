//! Check of a table against its mesh: its directions are traced again, and baked again where the
//! exact method can bake them.

use crate::cell::Prepared;
use crate::error::Error;
use crate::geometry::{Stream, centred};
use crate::optics::Backing;
use crate::plan::{Plan, Request};
use crate::run::bake::Bake;
use crate::run::bake::Progress;
use crate::run::bake::trace;
use crate::run::between::error_at;
use crate::run::checks::comparison::Comparison;
use crate::run::provenance::{Stated, stated};
use rayon::prelude::*;
use tables::options::{Back, Losses, Method, Sampler};
use tables::{Symmetry, Table};

/// Numbers of incidences and of azimuths that are traced again where the exact bake looks at all.
const PART: [usize; 2] = [4, 2];

/// Number of directions that have all of their rays where only rays can look. More directions share
/// as many rays, down to [`FEWEST`] each.
const WHOLE: u64 = 8;

/// Least number of rays of a direction: with them eta is known to 0.002.
const FEWEST: u64 = 1 << 16;

/// Number of random directions in which a tolerance between directions is tried.
const TRIED: u64 = 500;

/// Checks a table against its mesh by rays, and returns the comparison.
///
/// Where the exact method can bake the cell, so that [`rebake`] looks at all directions, `seed`
/// chooses some, and `rays` rays are traced through the cell in each of them. Otherwise rays are
/// traced in all directions; more than 8 of them share 8 times `rays`, and each has at least 65,536
/// of them unless `rays` is less. These rays are independent random points, whatever the table was
/// baked by, so their counting error is known.
///
/// # Errors
/// Returns [`Error::Stated`] if the table was baked with options that this version does not know,
/// if no bake takes them, or if the mesh lacks its symmetry; other errors if the rays cannot be
/// traced or the caller stopped them.
pub fn retrace(
    table: &Table,
    prepared: &Prepared,
    rays: u64,
    seed: u64,
    progress: Progress<'_>,
) -> Result<Comparison, Error> {
    let (incidences, azimuths) = table.axes.shape();
    let plan = again(table, prepared, rays, seed)?;
    if is_exact(&plan, prepared) {
        let part = part(table, seed);
        let plan = Plan {
            axes: part.axes.clone(),
            ..plan
        };
        return Ok(Comparison::of(&part, &trace(prepared, &plan, progress)?));
    }
    let shared = WHOLE.saturating_mul(rays) / (incidences * azimuths).max(1) as u64;
    let plan = again(table, prepared, shared.clamp(rays.min(FEWEST), rays), seed)?;
    Ok(Comparison::of(table, &trace(prepared, &plan, progress)?))
}

/// Makes the exact bake of a table in all its directions, and returns the comparison; of a table
/// with polygons, path by path.
///
/// Returns `None` if the exact method does not take the cell, or if the table is a mean over
/// azimuths.
///
/// # Errors
/// Returns the errors of [`retrace`].
pub fn rebake(
    table: &Table,
    prepared: &Prepared,
    progress: Progress<'_>,
) -> Result<Option<Comparison>, Error> {
    let plan = again(table, prepared, 1, 0)?;
    if !is_exact(&plan, prepared) {
        return Ok(None);
    }
    let baked = trace(prepared, &exactly(plan), progress)?;
    Ok(Some(Comparison::of(table, &baked)))
}

/// Returns the greatest error of a table that states a tolerance between its directions, in random
/// directions that `seed` chooses; `None` if it states none.
///
/// The error is infinite if the exact method does not take the cell: no bake states a tolerance
/// then.
///
/// # Errors
/// Returns the errors of [`retrace`].
pub fn error_between(table: &Table, prepared: &Prepared, seed: u64) -> Result<Option<f64>, Error> {
    if table.provenance.direction_tolerance.is_none() {
        return Ok(None);
    }
    let plan = exactly(again(table, prepared, 1, 0)?);
    if !is_exact(&plan, prepared) {
        return Ok(Some(f64::INFINITY));
    }
    let bake = Bake::new(prepared, &plan, Progress::none())?;
    let Some(exact) = bake.exact else {
        return Ok(Some(f64::INFINITY));
    };
    let axes = &table.axes;
    let all_around = table.provenance.symmetry != Symmetry::NONE || axes.goes_around();
    let stream = Stream::new(Sampler::Random, seed, 1.0, 0.0, 0);
    let share = |cell: u32| 0.5 + centred(cell);
    let between = |ends: &[f64], cell: u32| {
        let (first, last) = (ends[0], ends[ends.len() - 1]);
        first + (last - first) * share(cell)
    };
    let error = |index: u64| {
        let [a, b] = stream.pair(index);
        let incidence = between(&axes.incidence_deg, a);
        let azimuth = match all_around {
            true => 360.0 * share(b),
            false => between(&axes.azimuth_deg, b),
        };
        error_at(exact, &bake.rules, table, incidence, azimuth)
    };
    Ok(Some(
        (0..TRIED)
            .into_par_iter()
            .map(error)
            .reduce(|| 0.0, f64::max),
    ))
}

/// Returns whether the exact method bakes the directions of a plan one by one.
fn is_exact(plan: &Plan, prepared: &Prepared) -> bool {
    !plan.is_azimuth_mean() && plan.exact_cell(prepared).is_ok()
}

/// Returns a plan with the exact method.
fn exactly(plan: Plan) -> Plan {
    Plan {
        method: Method::Exact,
        ..plan
    }
}

/// Returns whether a table is as it would be with the other back: a mirror in place of total
/// reflection, or total reflection in place of a mirror.
///
/// # Errors
/// Returns the errors of [`retrace`].
pub(crate) fn is_blind_to_the_back(
    table: &Table,
    prepared: &Prepared,
    rays: u64,
    seed: u64,
    progress: Progress<'_>,
) -> Result<bool, Error> {
    let plan = again(table, prepared, rays, seed)?;
    if plan.losses.is_some() || plan.scene.glass_index.is_some() {
        return Ok(false);
    }
    let exact = is_exact(&plan, prepared);
    let part = match exact {
        true => table.clone(),
        false => part(table, seed),
    };
    let plan = Plan {
        axes: part.axes.clone(),
        back: match plan.back {
            Back::Mirror => Back::Tir,
            Back::Tir => Back::Mirror,
        },
        method: if exact { Method::Exact } else { Method::Rays },
        ..plan
    };
    Ok(Comparison::of(&part, &trace(prepared, &plan, progress)?).agrees())
}

/// Returns some directions of a table, chosen by `seed`.
fn part(table: &Table, seed: u64) -> Table {
    let axes = &table.axes;
    let incidences = some(axes.incidence_deg.len(), PART[0], seed);
    table.part(&incidences, &some(axes.azimuth_deg.len(), PART[1], seed))
}

/// Returns the plan of a bake by `rays` random rays in each direction of `table`, with its options.
///
/// Its options are checked as those of a user are.
pub(crate) fn again(
    table: &Table,
    prepared: &Prepared,
    rays: u64,
    seed: u64,
) -> Result<Plan, Error> {
    let from = &table.provenance;
    let Stated {
        back,
        losses,
        scene,
    } = stated(from).ok_or_else(|| {
        Error::Stated(
            "was baked with options that this version of bake does not know; install a newer \
            version"
                .into(),
        )
    })?;
    if from.symmetry != Symmetry::NONE && from.symmetry != prepared.symmetry() {
        return Err(Error::Stated(
            "claims a symmetry that the mesh does not have, so it is wrong at the azimuths that \
            it leaves out; bake it again"
                .into(),
        ));
    }
    let request = Request {
        refractive_index: Some(from.refractive_index),
        back,
        losses: losses.map_or(Losses::None, |_| Losses::Fresnel),
        reflectance: match losses {
            Some(Backing::Mirror { reflectance }) => Some(reflectance),
            _ => None,
        },
        metal: match losses {
            Some(Backing::Metal(index)) => Some(index),
            _ => None,
        },
        wavelength_nm: from.wavelength_nm,
        method: Method::Rays,
        sampler: Sampler::Random,
        rays: Some(rays),
        bins: table.axes.bins,
        range: table.axes.range,
        angular_tolerance_deg: from.angular_tolerance_deg,
        seed,
        scene,
        ..Request::default()
    };
    let plan = Plan::new(&request).map_err(|error| {
        Error::Stated(format!("states what no bake takes: {error}; bake it again"))
    })?;
    Ok(Plan {
        axes: table.axes.clone(),
        ..plan
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
