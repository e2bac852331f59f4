//! Why a campaign has no estimate.

use std::path::PathBuf;

use crate::estimate::scene;
use crate::estimate::watch::Cancelled;
use crate::model::wave;

/// What an estimate fails for.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The photographs.
    #[error(transparent)]
    Scene(scene::Error),
    /// The table.
    #[error(transparent)]
    Table(#[from] tables::Error),
    /// The wave kernel was asked for, but cannot be had.
    #[error("{}: {fault}", manifest.display())]
    Wave {
        /// The manifest.
        manifest: PathBuf,
        /// What it lacks.
        fault: wave::Fault,
    },
    /// A baseline that hollow cubes cannot have.
    #[error("{}: --model guo blurs by the roughness of the front, which hollow cubes lack (index \
    1 in the table); \
             name another model", manifest.display())]
    Hollow {
        /// The manifest.
        manifest: PathBuf,
    },
    /// The azimuth cannot be told by such a table.
    #[error(
        "--fit-azimuth: the table says nothing of other azimuths ({held}); bake them all: bake \
        trace --azimuth full \
             --direction-tolerance 0.005"
    )]
    OneAzimuth {
        /// What it holds.
        held: &'static str,
    },
    /// The solver found no optimum.
    #[error("{}: the fit failed (the model is not finite near its starting values); \
             check pixel_pitch_mm and the distances", manifest.display())]
    NoFit {
        /// The manifest.
        manifest: PathBuf,
    },
    /// Options that exclude each other.
    #[error(transparent)]
    Conflict(#[from] Conflict),
    /// No candidate is left.
    #[error("no kernel, or no lobe shape, is open; name at least one of each")]
    NothingOpen,
    /// It was asked to stop.
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

/// Options of an estimate that exclude each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Conflict {
    /// Samples beside the likelihood of pixels.
    #[error(
        "--forward render compares MTFs, as published; use --loss mtf or mse, or --forward spectral"
    )]
    PixelsBySamples,
    /// A model without samples.
    #[error(
        "this model has no samples: --forward render does eq1, angular, shift and lobe; use \
        --forward spectral"
    )]
    NoSamples,
    /// The azimuth of a model that knows none, or by samples.
    #[error(
        "--fit-azimuth looks for the azimuth in closed form and with the proposed model; leave \
        out --forward and --model"
    )]
    AzimuthOfAnother,
}
