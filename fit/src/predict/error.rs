//! Why a sheet shows nothing that could be predicted.

use crate::model::wave;
use crate::names::ParameterKind;

/// Why a sheet shows nothing that could be predicted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The result holds only a bound where a number is needed.
    #[error(
        "the result gives no number for {} (its photographs only bound it); \
             fit with a --kernel without it, or add photographs",
        parameter.name()
    )]
    Unknown {
        /// The parameter.
        parameter: ParameterKind,
    },
    /// The table is one of another cell than the fit's.
    #[error(
        "the result was fitted with a table of another cell ({fitted}) than this one ({given}): \
        mesh, edge length, \
             azimuth zero, refractive index, back, losses or options such as --roughness differ; \
             bake the fitted cell, or fit \
             again"
    )]
    OtherCell {
        /// Design and content hash in the result.
        fitted: String,
        /// Those of the table given.
        given: String,
    },
    /// Nothing returns, so that there is nothing to be like.
    #[error(
        "nothing is retroreflected at incidence {incidence_deg} deg; name a smaller --incidence"
    )]
    Dark {
        /// Incidence, degrees.
        incidence_deg: f64,
    },
    /// The table has no such direction.
    #[error(transparent)]
    Direction(#[from] tables::Error),
    /// The table has the direction, but not for the `wave` kernel.
    #[error(transparent)]
    Wave(#[from] wave::Fault),
}
