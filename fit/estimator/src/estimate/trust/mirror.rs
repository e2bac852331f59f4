//! Warning about a manifest that does not say which way the camera saw the sheet, where the
//! estimate depends on it.

use tables::Table;

use crate::estimate::scene::Scene;
use crate::estimate::search::compared::model;
use crate::estimate::search::fitted::{Estimate, estimate};
use crate::estimate::search::layout::Layout;
use crate::estimate::search::layout::Value;
use crate::estimate::search::loss::{Kind, Loss};
use crate::estimate::search::optimum::{optimum, refined};

/// Change of the MTF below which two views count as one: five times the rounding of the model.
const SAME: f64 = 1e-4;

/// Change of a parameter, in standard errors, from which an answer counts as another.
const ANOTHER: f64 = 0.5;

/// Returns a warning that names the answers of both views, if they differ: the camera looked at the
/// sheet straight (as `scene` takes it), or saw it in the mirror.
///
/// # Errors
/// Fails if the table neither holds nor brackets one of the directions.
pub(crate) fn unstated(
    scene: &Scene,
    table: &Table,
    kind: Kind,
    best: &Estimate,
) -> Result<Option<String>, tables::Error> {
    let mirrored = scene.mirrored(table)?;
    if !is_seen(scene, &mirrored, best) {
        return Ok(None);
    }
    let near = optimum(&mirrored, best.choice);
    let loss = Loss::new(kind, &mirrored, (best.choice, &near.solution.parameters));
    let other = estimate(&mirrored, &loss, refined(&mirrored, &loss, near));
    let changed = best.values().zip(other.values()).any(|(own, other)| {
        (own.value - other.value).abs() > ANOTHER * own.standard_error.min(other.standard_error)
    });
    Ok(changed.then(|| {
        format!(
            "the manifest does not say seen_in_mirror, which decides here: false, as taken, gives \
            {}; true gives {}; state it in [setup]",
            answer(best),
            answer(&other)
        )
    }))
}

/// Returns a warning if the azimuth was found and another one would be found in the other view: the
/// view changes the MTF of a photograph at this azimuth.
///
/// # Errors
/// Fails if the table neither holds nor brackets one of the directions.
pub(crate) fn unstated_azimuth(
    scene: &Scene,
    table: &Table,
    best: &Estimate,
) -> Result<Option<String>, tables::Error> {
    let seen = is_seen(scene, &scene.mirrored(table)?, best);
    Ok(seen.then(|| {
        "the manifest does not say seen_in_mirror, on which the azimuth that was found depends: \
         it is that of false, as taken; that of true is another, and c, a and mu may be too; \
         state it in [setup]"
            .into()
    }))
}

/// Returns whether the MTF of a photograph depends on the view.
fn is_seen(scene: &Scene, mirrored: &Scene, best: &Estimate) -> bool {
    let layout = Layout::of(best.choice, scene);
    scene.shots.iter().zip(&mirrored.shots).any(|(own, other)| {
        let blur = layout.blur(&best.solution.parameters, own.place);
        let mtf = |shot, f| model(shot, best.choice).otf(blur, f).value.norm();
        let mut frequencies = own.view.estimator.frequencies_per_mm.iter();
        frequencies.any(|&f| (mtf(own, f) - mtf(other, f)).abs() > SAME)
    })
}

/// Returns an estimate in words.
fn answer(fit: &Estimate) -> String {
    let one = |(id, value): (_, &Value)| format!("{id} {:.4}", value.value);
    let all: Vec<String> = fit.parameters.iter().zip(fit.values()).map(one).collect();
    let reduced = fit.reduced_chi2();
    format!(
        "{} (chi-square {reduced:.2} per degree of freedom)",
        all.join(", ")
    )
}
