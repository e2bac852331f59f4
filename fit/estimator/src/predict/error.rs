//! Reasons why a prediction cannot be made.

use crate::model::wave;
use edges::names::ParameterKind;

/// Reason why a prediction cannot be made.
#[derive(Debug, thiserror::Error)]
#[allow(
    missing_docs,
    reason = "the message of a variant says what its fields are"
)]
#[non_exhaustive]
pub enum Error {
    /// Parameter without a value: the photographs give only a bound.
    #[error(
        "the result gives no number for {} (the photographs give at most a bound); fit with a \
        --kernel without it, or add photographs",
        parameter.name()
    )]
    Unknown { parameter: ParameterKind },
    /// Number of a result that no sheet and no camera has.
    #[error(
        "the result says that {what} is {value}, but it must be {must_be}; estimate again, or \
        correct the file"
    )]
    Number {
        what: &'static str,
        value: f64,
        must_be: &'static str,
    },
    /// Table of another cell than the one that was fitted.
    #[error(
        "the result was fitted with a table of another cell ({fitted}) than this one ({given}), \
        with another {differs}; give a table of the fitted cell, or fit again"
    )]
    OtherCell {
        fitted: String,
        given: String,
        differs: String,
    },
    /// Incidence at which nothing is retroreflected.
    #[error(
        "nothing is retroreflected at incidence {incidence_deg} deg; name a smaller --incidence"
    )]
    Dark { incidence_deg: f64 },
    /// Direction that the table does not have.
    #[error(transparent)]
    Direction(#[from] tables::Error),
    /// Data that the `wave` kernel needs and lacks: a wavelength, or polygons of corner cubes.
    #[error(transparent)]
    Wave(#[from] wave::Fault),
}
