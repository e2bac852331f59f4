//! Why a verb ends.

use std::path::PathBuf;

use tables::OutputError;

use crate::estimate::error as estimate;
use crate::estimate::scene;
#[cfg(feature = "images")]
use crate::images::{metrics, render};
use crate::names::Family;
use crate::photographs::{captures, edge, photo};
use crate::predict::error as predict;
#[cfg(feature = "report")]
use crate::report::plot;
use crate::simulate::error as simulate;

/// Anything that ends a verb.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum Failure {
    /// The manifest.
    #[error(transparent)]
    Captures(#[from] captures::error::Error),
    /// A photograph.
    #[error(transparent)]
    Photo(#[from] photo::error::Error),
    /// The scene.
    #[error(transparent)]
    Scene(#[from] scene::Error),
    /// The table.
    #[error(transparent)]
    Table(#[from] tables::Error),
    /// The estimate. Boxed: every result of the verbs would grow with it.
    #[error(transparent)]
    Estimate(Box<estimate::Error>),
    /// The result is of another model than the one that was named.
    #[error("{}: is the fit of another model; fit this one: fit estimate captures.toml --table \
    table.h5 --model {} -o result.json",
        path.display(), asked.name())]
    Model {
        /// The result.
        path: PathBuf,
        /// The model named.
        asked: Family,
    },
    /// The prediction.
    #[error(transparent)]
    Predict(#[from] predict::Error),
    /// The comparison.
    #[cfg(feature = "images")]
    #[error(transparent)]
    Evaluate(#[from] metrics::error::Error),
    /// The mid-air image.
    #[cfg(feature = "images")]
    #[error(transparent)]
    Render(#[from] render::Error),
    /// The simulation.
    #[error(transparent)]
    Simulate(#[from] simulate::Error),
    /// An output.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A picture.
    #[cfg(feature = "report")]
    #[error(transparent)]
    Plot(#[from] plot::Error),
    /// No edge.
    #[error("{}: {fault}", image.display())]
    Edge {
        /// The photograph.
        image: PathBuf,
        /// What is wrong.
        fault: edge::fault::Fault,
    },
    /// A region outside of the photograph.
    #[error("{}: --roi {},{},{},{} does not lie in the picture ({width} x {height}); give \
    x,y,width,height in pixels",
        image.display(), roi.x, roi.y, roi.width, roi.height)]
    Roi {
        /// The photograph.
        image: PathBuf,
        /// The region.
        roi: crate::photographs::Roi,
        /// Width of the picture.
        width: usize,
        /// Height of the picture.
        height: usize,
    },
    /// A JSON file that is none, or another.
    #[error("{}: {message}; give a file that {expected}", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// What the parser said.
        message: String,
        /// What writes such files.
        expected: &'static str,
    },
    /// A result of several channels, of which one must be named.
    #[error("{}: holds one result for each of the channels {held}; name one with --channel", path.display())]
    Channel {
        /// The file.
        path: PathBuf,
        /// Names of its channels.
        held: String,
    },
    /// A table of another cell than the ranges name.
    #[error("{}: is not the table of the ideal cell that is simulated; bake it: bake design \
    {design} -o cell.obj, then \
             bake trace cell.obj --refractive-index {ior} --incidence 0:45:15 --azimuth 30", table.display())]
    OtherCell {
        /// The table.
        table: PathBuf,
        /// Refractive index of the cell.
        ior: f64,
        /// Its design.
        design: &'static str,
    },
    /// The azimuth cannot be told by such a table.
    #[error("--fit-azimuth: {} says nothing of other azimuths ({held}); bake them all: bake trace \
    --azimuth full \
             --direction-tolerance 0.005", table.display())]
    OneAzimuth {
        /// The table.
        table: PathBuf,
        /// What it holds.
        held: &'static str,
    },
    /// What both programs do with terminal, threads and outputs.
    #[error(transparent)]
    Terminal(#[from] tables::cli::Error),
    /// Threads could not be started.
    #[error(transparent)]
    Threads(#[from] tables::cli::NoThreads),
}

impl From<estimate::Error> for Failure {
    fn from(error: estimate::Error) -> Failure {
        Failure::Estimate(Box::new(error))
    }
}

impl Failure {
    /// 2 for wrong usage that clap cannot see, 1 for work that failed.
    pub(crate) fn code(&self) -> u8 {
        match self {
            #[cfg(feature = "report")]
            Failure::Plot(plot::Error::Format(_)) => 2,
            Failure::Terminal(tables::cli::Error::PlotExtension(_)) => 2,
            #[cfg(feature = "images")]
            Failure::Render(render::Error::Ending { .. }) => 2,
            _ => 1,
        }
    }
}
