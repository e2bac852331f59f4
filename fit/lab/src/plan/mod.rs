//! Which photographs to take: the campaign that tells c, a and mu best, before it is taken.
//!
//! Beliefs about the sheet, what can be set up, and a table of the cell enter. The photographs that
//! lower the standard errors most leave, with the errors to expect. The errors are Cramer-Rao bounds
//! of the pixels, which `fit estimate` reaches. They are averaged over the range of the beliefs, so
//! the plan holds anywhere in it.

mod exchange;
mod information;
mod request;
mod rival;
mod seen;

use serde::Serialize;
use tables::Table;

use crate::simulate::PlantedCamera;
use edges::names::{Kernel, ParameterId, ParameterKind};
use estimator::result::ResultFile;

use information::Foreseen;
pub use request::{Beliefs, Choices, Edge, Own, Plan};
pub use rival::{Apart, Told, chi_square};

/// Photographs beyond the planned ones whose use is computed.
const FURTHER: usize = 3;

/// A reason why nothing can be planned.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Table or photographs that cannot be used.
    #[error(transparent)]
    Estimator(#[from] estimator::Error),
    /// More photographs than choices.
    #[error(
        "{asked} photographs are asked for, but [choices] allows only {possible}; name more \
        choices, or raise `repeat`"
    )]
    TooMany {
        /// Photographs that are asked for.
        asked: usize,
        /// Photographs that can be taken.
        possible: usize,
    },
    /// Errors that the largest number of photographs does not reach.
    #[error(
        "{photographs} photographs, the most that are planned, do not reach the errors of `within`: \
        {} is then known to {:.2} %; ask for less, name more choices, or another camera",
        .kind.name(), 100.0 * .error.unwrap_or(f64::INFINITY)
    )]
    OutOfReach {
        /// Number of photographs.
        photographs: usize,
        /// Parameter that is not known well enough.
        kind: ParameterKind,
        /// Its largest error; `None` if nothing is known.
        error: Option<f64>,
    },
    /// Choices without light.
    #[error(
        "the table returns less than 2 % of the light in every direction of [choices]; name \
        smaller incidences"
    )]
    Dark,
    /// Result of another kernel than the plan believes.
    #[error(
        "--given is a fit of the kernel {}, but the plan believes {}; write it into [beliefs], \
        or give another result", given.name(), believed.name()
    )]
    OtherKernel {
        /// Kernel of the result.
        given: Kernel,
        /// Kernel of the plan.
        believed: Kernel,
    },
    /// Result without a parameter of the plan.
    #[error(
        "--given determines no parameter of the plan; leave it out, or let `per_angle` of \
        [beliefs] name what has one value per incidence in it"
    )]
    NothingGiven,
}

/// A planned campaign.
#[derive(Debug, Clone, Serialize)]
pub struct Planned {
    /// The photographs, in the order of the choices. One that is listed twice is to be taken twice.
    pub photographs: Vec<Photograph>,
    /// Errors to expect, for each parameter.
    pub expected: Vec<Expected>,
    /// Errors of the given result alone; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub now: Option<Vec<Expected>>,
    /// Errors of as many photographs that are spread evenly over the choices.
    pub even: Vec<Expected>,
    /// How well the photographs tell two kernels apart, by which of them is right; empty unless the
    /// plan asks. An earlier result has no part in it, so with one it is a lower limit.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub apart: Vec<Apart>,
    /// The same for as many photographs that are spread evenly.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub even_apart: Vec<Apart>,
    /// Errors after each of the next best photographs, and which they are.
    pub further: Vec<Further>,
    /// Number of photographs that could be taken.
    pub candidates: usize,
    /// Choices that were left out because the table returns no light there.
    pub dark: usize,
    /// Camera for which the errors hold, in words.
    pub camera: String,
    /// Warnings about the plan, one sentence each.
    pub warnings: Vec<String>,
}

/// A photograph to take.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Photograph {
    /// Floating distance, mm.
    pub floating_distance_mm: f64,
    /// Incidence in the air, degrees.
    pub incidence_deg: f64,
    /// Azimuth, degrees.
    pub azimuth_deg: f64,
    /// Axis across which the edge lies.
    pub edge: Edge,
    /// Exposure relative to that of the source edge, which brings the bright side to 0.8 of full
    /// scale in the middle of the beliefs.
    pub exposure: f64,
}

/// Standard error to expect of a parameter, relative to its value.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Expected {
    /// The parameter, by its name in results: `c_mm`, `a_per_mm_at_20`, `mu`.
    pub parameter: ParameterId,
    /// Its error in the middle of the beliefs; null if the photographs do not determine it.
    pub middle: Option<f64>,
    /// The largest error at the middle and the ends of the beliefs.
    pub largest: Option<f64>,
}

impl Expected {
    /// Returns the errors of each kind of parameter in the middle of the beliefs, as the root of the
    /// mean square; `None` of a kind that the photographs do not determine.
    pub fn by_kind(all: &[Expected]) -> Vec<(ParameterKind, Option<f64>)> {
        let kinds = all.chunk_by(|a, b| a.parameter.kind == b.parameter.kind);
        let error = |own: &[Expected]| {
            let squares: Option<f64> = own.iter().map(|own| own.middle.map(|v| v * v)).sum();
            (
                own[0].parameter.kind,
                squares.map(|sum| (sum / own.len() as f64).sqrt()),
            )
        };
        kinds.map(error).collect()
    }
}

/// What a further photograph would bring.
#[derive(Debug, Clone, Serialize)]
pub struct Further {
    /// The photograph.
    pub photograph: Photograph,
    /// Errors with it and those before it.
    pub expected: Vec<Expected>,
    /// Chi-square by which it and those before it show the other kernel to be worse, in the middle of
    /// the beliefs; absent unless the plan asks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chi2: Option<f64>,
}

/// Plans a campaign.
///
/// The best photographs are found by exchange: one after the other is replaced by the best of all
/// that could be taken, until none is replaced. The measure is the sum of the relative variances that
/// the plan minimises (of a parameter with a value per incidence, their mean), averaged as a
/// logarithm over the beliefs. If kernels are to be told apart, the logarithm of the chi-square that
/// does so is subtracted. `given` is an earlier result of the sheet, whose information the
/// photographs add to (see [`Plan::follow`]).
///
/// # Errors
/// Returns [`Error::Estimator`] if the table neither holds nor brackets a direction, or has no waves,
/// [`Error::Dark`] if it returns no light in any, [`Error::TooMany`] if fewer can be taken, and [`Error::OtherKernel`] or
/// [`Error::NothingGiven`] if nothing follows from `given`.
pub fn plan(plan: &Plan, table: &Table, given: Option<&ResultFile>) -> Result<Planned, Error> {
    let foreseen = Foreseen::new(plan, table)?;
    let known = given.map(|result| foreseen.known(result)).transpose()?;
    let possible = foreseen.candidates.len() * plan.choices.repeat;
    let search = exchange::Search::new(&foreseen, known.as_ref(), plan);
    let expected = |chosen: &[usize]| foreseen.expected(chosen, known.as_ref());
    let mut chosen = match plan.photographs {
        Some(asked) if asked > possible => return Err(Error::TooMany { asked, possible }),
        Some(asked) => search.best(asked),
        None => fewest(plan, possible, |count| {
            let chosen = search.best(count);
            let errors = expected(&chosen);
            (chosen, errors)
        })?,
    };
    chosen.sort_unstable();
    let even = foreseen.even(chosen.len());
    let (mut more, mut further) = (chosen.clone(), Vec::new());
    for _ in 0..FURTHER.min(possible - chosen.len()) {
        more.push(search.next(&more));
        let photograph = foreseen.photograph(more[more.len() - 1]);
        let expected = foreseen.expected(&more, known.as_ref());
        further.push(Further {
            photograph,
            expected,
            chi2: foreseen.chi2(&more)?,
        });
    }
    let photographs: Vec<Photograph> = chosen.iter().map(|&i| foreseen.photograph(i)).collect();
    let errors = expected(&chosen);
    Ok(Planned {
        camera: plan.camera.words(),
        warnings: warnings(plan, &photographs, &errors),
        expected: errors,
        photographs,
        now: known
            .as_ref()
            .map(|known| foreseen.expected(&[], Some(known))),
        even: foreseen.expected(&even, known.as_ref()),
        apart: foreseen.apart(&chosen)?,
        even_apart: foreseen.apart(&even)?,
        further,
        candidates: foreseen.candidates.len(),
        dark: foreseen.dark,
    })
}

/// Returns the fewest photographs whose errors are as wanted, as `best` finds them for a number of
/// them. Their number is bracketed by doubling, then bisected.
///
/// # Errors
/// Returns [`Error::OutOfReach`] if no number that is planned is enough.
fn fewest(
    plan: &Plan,
    possible: usize,
    best: impl Fn(usize) -> (Vec<usize>, Vec<Expected>),
) -> Result<Vec<usize>, Error> {
    let most = possible.min(request::MOST);
    let (mut below, mut count) = (0, 1);
    let mut enough = loop {
        let (chosen, errors) = best(count);
        match (beyond(plan, &errors), count < most) {
            (None, _) => break chosen,
            (Some(_), true) => (below, count) = (count, (2 * count).min(most)),
            (Some(own), false) => {
                return Err(Error::OutOfReach {
                    photographs: most,
                    kind: own.parameter.kind,
                    error: own.largest,
                });
            }
        }
    };
    while count - below > 1 {
        let middle = below + (count - below) / 2;
        let (chosen, errors) = best(middle);
        match beyond(plan, &errors) {
            None => (count, enough) = (middle, chosen),
            Some(_) => below = middle,
        }
    }
    Ok(enough)
}

/// Returns a parameter whose largest error is above the wanted one.
fn beyond<'a>(plan: &Plan, errors: &'a [Expected]) -> Option<&'a Expected> {
    errors.iter().find(|own| {
        let mut wanted = plan.within.iter();
        let wanted = wanted.find(|(kind, _)| *kind == own.parameter.kind);
        wanted.is_some_and(|&(_, most)| own.largest.is_none_or(|error| error > most))
    })
}

/// Returns warnings about a plan: errors that are not reached, and incidences of which nothing will
/// be known.
fn warnings(plan: &Plan, photographs: &[Photograph], errors: &[Expected]) -> Vec<String> {
    let beyond = beyond(plan, errors).map(|own| {
        format!(
            "{} photographs do not reach the errors of `within` ({}): leave out `photographs` to \
            plan as few as are enough",
            photographs.len(),
            own.parameter
        )
    });
    let incidences = plan.choices.incidence_deg.iter();
    let left: Vec<String> = incidences
        .filter(|&deg| photographs.iter().all(|own| own.incidence_deg != *deg))
        .map(|deg| format!("{deg}\u{b0}"))
        .collect();
    let left = (!left.is_empty() && !plan.beliefs.per_angle.is_empty()).then(|| {
        format!(
            "no photograph at {}: what has one value per incidence stays unknown there; leave out \
            `minimise` to learn all, or `per_angle = []` for one value",
            left.join(", ")
        )
    });
    beyond.into_iter().chain(left).collect()
}

impl Planned {
    /// Returns in two sentences under which conditions the errors hold.
    pub fn conditions(&self) -> String {
        format!(
            "The errors hold for {}. Lens, pixel pitch, distances and exposures are taken as right; \
             an estimate says what their errors would do.",
            self.camera
        )
    }

    /// Returns the manifest to fill in: with the names of the photographs to come, and their
    /// exposures as they should be.
    pub fn manifest(&self, camera: &PlantedCamera) -> String {
        let mut text = format!(
            "# Planned by fit plan. Take these photographs under the names below, and write the\n\
            # exposures that you used: they count relative to that of the source.\n\n\
            [setup]\npixel_pitch_mm = {}\nseen_in_mirror = {}\nhalf_mirror_transmittance = {}\n\
            half_mirror_reflectance = {}\n\n[reference]\nimage = \"source.tif\"\nexposure = 1\n",
            camera.pixel_pitch_mm,
            camera.seen_in_mirror,
            camera.half_mirror_transmittance,
            camera.half_mirror_reflectance
        );
        for (number, own) in (1..).zip(&self.photographs) {
            text += &format!(
                "\n# The edge runs across the {} axis, turned by some 5 degrees.\n[[capture]]\n\
                image = \"aerial_{number:02}.tif\"\nfloating_distance_mm = {}\nincidence_deg = {}\n\
                azimuth_deg = {}\nexposure = {}\n",
                own.edge.name(),
                own.floating_distance_mm,
                own.incidence_deg,
                own.azimuth_deg,
                rounded(own.exposure)
            );
        }
        text
    }
}

/// Plans a campaign and tries every choice of as many photographs too: returns the measure of the
/// exchange and the least of all.
#[cfg(test)]
pub(crate) fn exhaustive(plan: &Plan, table: &Table) -> Result<(f64, f64), Error> {
    let foreseen = Foreseen::new(plan, table)?;
    let search = exchange::Search::new(&foreseen, None, plan);
    let (mut least, n) = (f64::INFINITY, foreseen.candidates.len());
    let count = plan.photographs.expect("a number");
    let mut choice = vec![0; count];
    loop {
        least = least.min(search.of(&choice));
        let Some(i) = (0..choice.len()).rev().find(|&i| choice[i] + 1 < n) else {
            break;
        };
        let next = choice[i] + 1;
        choice[i..].fill(next);
    }
    Ok((search.of(&search.best(count)), least))
}

/// Returns as many photographs as a plan asks for, spread evenly over its choices.
#[cfg(test)]
pub(crate) fn evenly(plan: &Plan, table: &Table) -> Result<Vec<Photograph>, Error> {
    let foreseen = Foreseen::new(plan, table)?;
    let even = foreseen
        .even(plan.photographs.expect("a number"))
        .into_iter();
    Ok(even.map(|i| foreseen.photograph(i)).collect())
}

/// Returns a number with three digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
