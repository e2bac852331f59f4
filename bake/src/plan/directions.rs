//! Reading of directions as a user types them.

use crate::error::Error;
use crate::plan::default;
use crate::plan::effort::{number, positive};
use crate::plan::request::Request;
use tables::Symmetry;
use tables::cli::list;
use tables::options::Method;

/// Reads a list of angles such as `0,15,30` or `0:45:5`, degrees.
///
/// The result is ascending and has no angle twice.
pub(crate) fn angles(option: &str, text: &str) -> Result<Vec<f64>, Error> {
    let mut angles = list(text).map_err(|reason| {
        let or = match option {
            "--azimuth" => ", full or mean",
            _ => "",
        };
        Error::Usage(format!("{option} {text}, degrees: {reason}{or}"))
    })?;
    angles.sort_by(f64::total_cmp);
    angles.dedup();
    // Adding 0 turns -0 into 0.
    Ok(angles.into_iter().map(|angle| angle + 0.0).collect())
}

/// Returns the step of `full` or `full:STEP`, degrees, or `None` if not all azimuths are asked for.
pub(crate) fn full_step(text: &str) -> Result<Option<f64>, Error> {
    match text.trim().split_once(':') {
        None if text.trim() == "full" => Ok(Some(default::FULL_STEP_DEG)),
        Some(("full", step)) => {
            let range = "from 0.01 to 90, the widest step between azimuths, as in full:2";
            let step = step.trim().parse().map_err(|_| {
                let fault = format!("\"{step}\" is not a number; give one {range}");
                Error::Usage(format!("--azimuth {text}: {fault}"))
            })?;
            number("--azimuth full", step, (0.01..=90.0).contains(&step), range)?;
            Ok(Some(step))
        }
        _ => Ok(None),
    }
}

/// Returns evenly spaced azimuths, at most `step` degrees apart, that stand for all azimuths.
///
/// They lie in the sector that repeats by `symmetry`.
pub(crate) fn sector(symmetry: Symmetry, step: f64) -> Vec<f64> {
    let (first, width) = symmetry.sector_deg();
    // Half a thousandth of a step allows for the rounding of steps such as 0.1. There are at least
    // two steps, so that every other azimuth lies between two of these.
    let steps = (width / step - 5e-4).ceil().max(2.0) as u32;
    let last = match symmetry.mirror_deg {
        Some(_) => steps,
        None => steps - 1,
    };
    let azimuths = (0..=last).map(|k| first + width * f64::from(k) / f64::from(steps));
    azimuths.collect()
}

/// Returns the tolerance of `--direction-tolerance`, a total variation, or `None` if it is not
/// given.
///
/// The option is for exact tables of single azimuths only.
pub(crate) fn direction_tolerance(request: &Request) -> Result<Option<f64>, Error> {
    let option = "--direction-tolerance";
    let Some(tolerance) = request.direction_tolerance else {
        return Ok(None);
    };
    let range = "above 0 and at most 1, a total variation";
    positive(option, tolerance, 1.0, range)?;
    let other = match (request.method, request.azimuth.trim()) {
        (Method::Rays, _) => "--method rays",
        (_, "mean") => "--azimuth mean",
        _ => return Ok(Some(tolerance)),
    };
    Err(Error::both(option, other))
}
