//! Polarised light: a table as it is seen through the polarisers, the film and the half mirror of a
//! setup.

use std::borrow::Cow;

use edges::document::FileLine;
use edges::names::Polarisation;
use edges::photographs::manifest::captures;
use tables::{Passage, Table};

use crate::error::Error;

/// Share of the returned light that must pass the setup. Crossed polarisers are dark but for
/// rounding (1e-32), and a luminance that is divided by that has no meaning.
const LEAST: f64 = 1e-9;

/// Reason why a table cannot be seen in the light of a setup.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    /// Table that does not say how its cubes turn the polarisation.
    #[error(transparent)]
    Table(#[from] tables::Error),
    /// Setup through which no light passes.
    #[error(
        "less than 1e-9 of the light of this table passes `polarisation`, `retarder`, `analyser` \
        and the half mirror together; turn one of them, or leave it out"
    )]
    Dark,
}

impl From<Fault> for Error {
    fn from(fault: Fault) -> Error {
        match fault {
            Fault::Table(error) => error.into(),
            Fault::Dark => {
                let place = FileLine {
                    file: "[setup]".into(),
                    line: 0,
                };
                captures::Error::from(place.error(fault.to_string())).into()
            }
        }
    }
}

/// Returns the table as the light of a setup sees it. Without polarisation it is the table itself.
///
/// # Errors
/// Returns [`tables::Error::Polarised`] if the table does not say how its cubes turn the
/// polarisation, and [`Fault::Dark`] if nothing passes the setup in any direction of the table.
pub fn seen<'a>(
    table: &'a Table,
    polarisation: Option<&Polarisation>,
    seen_in_mirror: bool,
) -> Result<Cow<'a, Table>, Fault> {
    let Some(light) = polarisation.filter(|_| table.passage.is_none()) else {
        return Ok(Cow::Borrowed(table));
    };
    let [before, after] = light.ways(seen_in_mirror);
    let seen = table.clone().seen_through(Passage { before, after })?;
    match is_dark(table, &seen) {
        true => Err(Fault::Dark),
        false => Ok(Cow::Owned(seen)),
    }
}

/// Returns whether a table returns light, but none of it in any direction as it is seen.
fn is_dark(table: &Table, seen: &Table) -> bool {
    let azimuths = || table.axes.azimuth_deg.iter();
    let incidences = table.axes.incidence_deg.iter();
    let places = incidences.flat_map(|&incidence| azimuths().map(move |&own| (incidence, own)));
    let mut shares = places.filter_map(|(incidence_deg, azimuth_deg)| {
        let light = |of: &Table| {
            let direction = of.direction(incidence_deg, Some(azimuth_deg)).ok()?;
            Some(direction.retroreflected)
        };
        let all = light(table).filter(|&all| all > 0.0)?;
        Some(light(seen)? / all)
    });
    let first = shares.next();
    first.is_some_and(|first| first < LEAST && shares.all(|share| share < LEAST))
}
