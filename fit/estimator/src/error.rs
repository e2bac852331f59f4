//! Reasons why a campaign has no estimate, and a result no prediction.

use std::path::PathBuf;

use crate::estimate::progress::Cancelled;
use crate::model::wave;
use edges::document::Bounds;
use edges::names::ParameterKind;
use edges::photographs::edge::fault::Fault;
use edges::photographs::manifest::captures;

/// Reason why an estimate or a prediction failed.
#[derive(Debug, thiserror::Error)]
#[allow(
    missing_docs,
    reason = "the message of a variant says what its fields are"
)]
#[non_exhaustive]
pub enum Error {
    /// Manifest or photograph that cannot be read.
    #[error(transparent)]
    Captures(#[from] captures::Error),
    /// Direction that the table does not have.
    #[error("{}: capture \"{image}\": {source}", manifest.display())]
    Direction {
        /// File of the manifest.
        manifest: PathBuf,
        /// Image of the capture.
        image: String,
        /// Error of the table. It is boxed, because otherwise every result of the crate would be
        /// larger.
        source: Box<tables::Error>,
    },
    /// Photograph without a usable edge.
    #[error("{}: {}", .0.display(), .1)]
    Edge(PathBuf, Fault),
    /// Photograph that is sharper than the reference.
    #[error("{}: capture \"{image}\" is sharper than the [reference], but a sheet only adds blur: \
             the two photographs may be exchanged, or the reference is out of focus; exchange or \
             repeat them", manifest.display())]
    Sharper {
        /// File of the manifest.
        manifest: PathBuf,
        /// Image of the capture.
        image: String,
    },
    /// Campaign in which no capture returns light.
    #[error("{}: no capture is left: the table says that nothing is retroreflected at the \
             incidence of any capture; photograph at smaller incidences, or check azimuth_deg",
             .0.display())]
    NothingLeft(PathBuf),
    /// Table without a direction that is needed.
    #[error(transparent)]
    Table(#[from] tables::Error),
    /// Wave kernel named alone, but impossible with this campaign and table.
    #[error("{}: {}", .0.display(), .1)]
    Wave(PathBuf, wave::Fault),
    /// Baseline that needs a front face, named alone for hollow cubes.
    #[error("{}: --model guo needs a front face, but the table's cubes are hollow (refractive \
             index 1); choose another --model", .0.display())]
    Hollow(PathBuf),
    /// Table that cannot tell the azimuth, and the azimuths that it holds, in words.
    #[error(
        "--fit-azimuth: the table says nothing of other azimuths ({0}); bake them all: bake \
        trace --azimuth full --direction-tolerance 0.005"
    )]
    OneAzimuth(&'static str),
    /// Fit without a finite optimum.
    #[error("{}: the fit failed (the model is not finite near its starting values); \
             check pixel_pitch_mm and the distances", .0.display())]
    NoFit(PathBuf),
    /// Options that exclude each other.
    #[error(transparent)]
    Conflict(#[from] Conflict),
    /// No candidate left.
    #[error("no kernel or no lobe shape is left to try; name at least one of each")]
    NothingOpen,
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
    /// Table of a result of polarised light that is not seen through it.
    #[error(
        "the result is of polarised light, and the table is seen by unpolarised light; give the \
        table that ResultFile::seen returns"
    )]
    Unpolarised,
    /// Incidence at which nothing is retroreflected.
    #[error(
        "nothing is retroreflected at incidence {incidence_deg} deg; name a smaller --incidence"
    )]
    Dark { incidence_deg: f64 },
    /// Data that the `wave` kernel needs and lacks: a wavelength, or polygons of corner cubes.
    #[error(transparent)]
    Waves(#[from] wave::Fault),
    /// Estimate stopped by its caller.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Pair of options that exclude each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Conflict {
    /// Samples together with the likelihood of pixels.
    #[error(
        "--forward render compares MTFs, not pixels; use --loss mtf or --loss mse, or \
        --forward spectral"
    )]
    PixelsBySamples,
    /// Candidates of which none has samples.
    #[error(
        "this model has no samples: --forward render can only do the kernels eq1, angular, shift \
        and lobe; use --forward spectral"
    )]
    NoSamples,
    /// Azimuth wanted for a model without one, or by samples.
    #[error(
        "--fit-azimuth works only in closed form and with the proposed model; leave out --forward \
        and --model"
    )]
    AzimuthOfAnother,
}

/// Checks that numbers of a result lie within their bounds.
///
/// # Errors
/// Returns [`Error::Number`] about the first one that does not.
pub(crate) fn all_within<const N: usize>(
    checked: [(&'static str, Vec<f64>, Bounds); N],
) -> Result<(), Error> {
    for (what, values, bounds) in checked {
        let wrong = |value: &&f64| !(value.is_finite() && (bounds.holds)(**value));
        if let Some(&value) = values.iter().find(wrong) {
            return Err(Error::Number {
                what,
                value,
                must_be: bounds.words,
            });
        }
    }
    Ok(())
}
