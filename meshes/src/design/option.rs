//! Range of an option.

use crate::mesh::error::Fault;

/// Checks that an option of a design is a number from `least` to `most`.
pub(crate) fn inside(option: &'static str, value: f64, least: f64, most: f64) -> Result<(), Fault> {
    // NaN is outside of every range.
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(Fault::DesignOption {
            option,
            value,
            least,
            most,
        })
    }
}
