//! Errors that end a verb.

use std::path::PathBuf;

use edges::document::FileLine;
use edges::names::Family;
use edges::photographs::photo::plane::as_shown;
use edges::photographs::{edge, manifest::captures, photo};
#[cfg(feature = "full")]
use lab::simulate::error as simulate;

/// Error that ends a verb.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum Failure {
    /// Fault of the manifest.
    #[error(transparent)]
    Captures(#[from] captures::Error),
    /// Fault of a photograph.
    #[error(transparent)]
    Photo(#[from] photo::error::Error),
    /// Fault of the table.
    #[error(transparent)]
    Table(#[from] tables::Error),
    /// Failure of the estimate or the prediction. It is boxed because it would enlarge the results
    /// of all verbs.
    #[error(transparent)]
    Estimator(Box<estimator::Error>),
    /// Result of another model than the one that was named.
    #[error("{}: is the fit of another model; fit this one: fit estimate captures.toml --table \
    table.h5 --model {} -o result.json",
        path.display(), asked.name())]
    Model { path: PathBuf, asked: Family },
    /// Verb that has moved to the Python package.
    #[error(
        "evaluate: pictures are compared in Python; pip install \"midair[evaluate]\", then \
        midair.evaluate(\"rendered.png\", \"photograph.png\")"
    )]
    Evaluate,
    /// Failure of the mid-air image, or of the page with sliders.
    #[cfg(feature = "full")]
    #[error(transparent)]
    Pictures(#[from] pictures::Error),
    /// Failure of a plan.
    #[cfg(feature = "full")]
    #[error(transparent)]
    Plan(#[from] lab::plan::Error),
    /// Failure of the simulation.
    #[cfg(feature = "full")]
    #[error(transparent)]
    Simulate(#[from] simulate::Error),
    /// Table of another content hash than `--expect-table` or the manifest names.
    #[error(
        "{}: has the content hash {found}, not that of {asked}; get the table from who gave you \
        the hash, or leave that out",
        table.display()
    )]
    OtherTable {
        table: PathBuf,
        found: String,
        /// Option or key that names the expected hash.
        asked: String,
    },
    /// Manifest and command line that ask for different tables.
    #[error(
        "{place}: `expect_table` and --expect-table name different hashes, {key} and {option}; \
        correct one of them, or leave one out"
    )]
    TwoTables {
        place: FileLine,
        key: String,
        option: String,
    },
    /// Photograph without a usable edge.
    #[error("{}: {fault}", image.display())]
    Edge {
        image: PathBuf,
        fault: edge::fault::Fault,
    },
    /// Folder without a photograph.
    #[error("{}: {message}; name a photograph, or a folder that holds some", folder.display())]
    Folder { folder: PathBuf, message: String },
    /// Photographs that were refused, while others were measured.
    #[error(
        "{refused} of {of} photographs were refused; the lines above and the column `error` \
    say why; mend them or leave them out"
    )]
    Refused { refused: usize, of: usize },
    /// Frequency at which there is no curve.
    #[error(
        "--at {frequency}: lies above the sampling frequency, where no curve is; name at most \
    {most} {unit}"
    )]
    Frequency {
        frequency: f64,
        most: f64,
        unit: &'static str,
    },
    /// Region of interest that does not lie in the photograph.
    #[error("{}: --roi {},{},{},{} does not lie in the picture ({width} x {height}{}); \
    give x,y,width,height in pixels",
        image.display(), roi.x, roi.y, roi.width, roi.height, as_shown(*turned))]
    Roi {
        image: PathBuf,
        roi: edges::photographs::Roi,
        width: usize,
        height: usize,
        turned: bool,
    },
    /// File that is no JSON, or JSON of another kind.
    #[error("{}: {message}; give a file that {expected}", path.display())]
    Json {
        path: PathBuf,
        message: String,
        expected: &'static str,
    },
    /// Result of several channels, of which none was named.
    #[error("{}: holds one result for each of the channels {held}; name one with --channel",
        path.display())]
    Channel { path: PathBuf, held: String },
    /// Table of another cell than the ranges name.
    #[error("{}: is not the table of the ideal cell that is simulated; bake that table: \
    bake design {design} -o cell.obj, then \
    bake trace cell.obj --refractive-index {refractive_index} --incidence 0:45:15 --azimuth 30",
        table.display())]
    OtherCell {
        table: PathBuf,
        refractive_index: f64,
        design: &'static str,
    },
    /// Table without the azimuths that `--fit-azimuth` needs.
    #[error("--fit-azimuth: {} does not tell azimuths apart ({held}); bake one of all azimuths: \
    bake trace --azimuth full --direction-tolerance 0.005",
        table.display())]
    OneAzimuth { table: PathBuf, held: &'static str },
    /// Work that the caller stopped.
    #[error("stopped")]
    Stopped,
    /// Wrong usage, as clap says it.
    #[error("{}", .0.render())]
    Usage(#[from] clap::Error),
}

impl From<estimator::Error> for Failure {
    fn from(error: estimator::Error) -> Failure {
        Failure::Estimator(Box::new(error))
    }
}

impl Failure {
    /// Makes the failure of options of `verb` that exclude each other.
    pub(crate) fn conflict(verb: &'static str, message: impl std::fmt::Display) -> Failure {
        clap::Command::new(verb)
            .override_usage(format!("{verb} [OPTIONS]"))
            .error(clap::error::ErrorKind::ArgumentConflict, message)
            .into()
    }

    /// Returns the exit code: 2 for wrong usage that clap cannot see, 1 for work that failed.
    pub(crate) fn code(&self) -> u8 {
        match self {
            Failure::Table(tables::Error::PlotExtension(_)) => 2,
            Failure::Frequency { .. } | Failure::Usage(_) => 2,
            #[cfg(feature = "full")]
            Failure::Pictures(
                pictures::Error::Ending(_)
                | pictures::Error::SampledCamera
                | pictures::Error::SampledColours
                | pictures::Error::Seat(_),
            ) => 2,
            _ => 1,
        }
    }
}
