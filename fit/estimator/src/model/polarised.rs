//! Polarised light: a table as it is seen through the polarisers, the film and the half mirror of a
//! setup.

use std::borrow::Cow;

use edges::names::Polarisation;
use tables::{Passage, Table};

/// Returns the table as the light of a setup sees it. Without polarisation it is the table itself.
///
/// # Errors
/// Returns [`tables::Error::Polarised`] if the table does not say how its cubes turn the
/// polarisation.
pub fn seen<'a>(
    table: &'a Table,
    polarisation: Option<&Polarisation>,
    seen_in_mirror: bool,
) -> Result<Cow<'a, Table>, tables::Error> {
    let Some(light) = polarisation.filter(|_| table.passage.is_none()) else {
        return Ok(Cow::Borrowed(table));
    };
    let [before, after] = light.ways(seen_in_mirror);
    let seen = table.clone().seen_through(Passage { before, after })?;
    Ok(Cow::Owned(seen))
}
