//! Checks of numbers against their ranges.

use crate::error::Error;

/// Refuses a number that is not `allowed`; `range` says in words what is.
pub(crate) fn number(option: &str, value: f64, allowed: bool, range: &str) -> Result<(), Error> {
    match allowed {
        true => Ok(()),
        false => Err(Error::Usage(format!(
            "{option} {value}: give a number {range}"
        ))),
    }
}

/// Checks that a number is above 0 and at most `most`; `range` says so in words.
pub(crate) fn positive(option: &str, value: f64, most: f64, range: &str) -> Result<(), Error> {
    number(option, value, value > 0.0 && value <= most, range)
}

/// Checks that a whole number is from 1 to `most`.
pub(crate) fn count(option: &str, value: u64, most: u64) -> Result<(), Error> {
    if (1..=most).contains(&value) {
        return Ok(());
    }
    let range = format!("give a whole number from 1 to {most}");
    Err(Error::Usage(format!("{option} {value}: {range}")))
}

/// Largest number of rays of a direction in one randomisation.
///
/// A scrambled sequence has no more distinct points.
pub(crate) const RAYS_PER_RANDOMISATION: u64 = 1 << 32;

/// Largest number of bins along an axis.
pub(crate) const BINS_LIMIT: usize = 4096;

/// Largest array of a table, bytes. A table with a larger one could not be read again.
pub(crate) const MOST_BYTES: u64 = 1 << 31;
