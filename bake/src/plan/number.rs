//! Checks of numbers against their ranges.

use crate::plan::error::PlanError;

/// Checks that a number is above 0 and at most `most`; `range` says this in the message.
pub(crate) fn positive(
    option: &'static str,
    value: f64,
    most: f64,
    range: &'static str,
) -> Result<(), PlanError> {
    if value > 0.0 && value <= most {
        Ok(())
    } else {
        Err(PlanError::Number {
            option,
            value,
            range,
        })
    }
}

/// Checks that a whole number is from 1 to `most`.
pub(crate) fn count(option: &'static str, value: u64, most: u64) -> Result<(), PlanError> {
    if (1..=most).contains(&value) {
        Ok(())
    } else {
        Err(PlanError::Count {
            option,
            value,
            most,
        })
    }
}
