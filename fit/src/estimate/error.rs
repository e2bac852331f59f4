//! Reasons why a campaign has no estimate.

use std::path::PathBuf;

use crate::estimate::scene;
use crate::estimate::watch::Cancelled;
use crate::model::wave;

/// Reason why an estimate failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Photographs that make no scene.
    #[error(transparent)]
    Scene(scene::Error),
    /// Table without a direction that is needed.
    #[error(transparent)]
    Table(#[from] tables::Error),
    /// Wave kernel named alone, but impossible with this campaign and table.
    #[error("{}: {fault}", manifest.display())]
    Wave {
        /// File of the manifest.
        manifest: PathBuf,
        /// Reason why there are no waves.
        fault: wave::Fault,
    },
    /// Baseline that needs a front face, named alone for hollow cubes.
    #[error("{}: --model guo needs a front face, but the table's cubes are hollow (refractive \
             index 1); choose another --model", manifest.display())]
    Hollow {
        /// File of the manifest.
        manifest: PathBuf,
    },
    /// Table that cannot tell the azimuth.
    #[error(
        "--fit-azimuth: the table says nothing of other azimuths ({held}); bake them all: bake \
        trace --azimuth full --direction-tolerance 0.005"
    )]
    OneAzimuth {
        /// Azimuths that the table holds, in words.
        held: &'static str,
    },
    /// Fit without a finite optimum.
    #[error("{}: the fit failed (the model is not finite near its starting values); \
             check pixel_pitch_mm and the distances", manifest.display())]
    NoFit {
        /// File of the manifest.
        manifest: PathBuf,
    },
    /// Options that exclude each other.
    #[error(transparent)]
    Conflict(#[from] Conflict),
    /// No candidate left.
    #[error("no kernel or no lobe shape is left to try; name at least one of each")]
    NothingOpen,
    /// Estimate stopped by its caller.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<scene::Error> for Error {
    fn from(error: scene::Error) -> Error {
        match error {
            scene::Error::Cancelled(cancelled) => Error::Cancelled(cancelled),
            other => Error::Scene(other),
        }
    }
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
