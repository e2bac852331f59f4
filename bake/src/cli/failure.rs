//! Failures of the verbs of `bake`: one sentence each, and the exit code of the program.

use std::path::PathBuf;

use meshes::Fault;
use thiserror::Error;

use crate::plan::PlanError;
use crate::run::RunError;
use crate::study::StudyError;

/// Failure of a verb, as one sentence for the user.
#[derive(Debug, Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    Plan(#[from] PlanError),
    #[error("{option} {text}: give {count} numbers separated by commas, such as {example}")]
    Numbers {
        option: &'static str,
        text: String,
        count: usize,
        example: &'static str,
    },
    #[error(transparent)]
    Design(Fault),
    #[error("-o {}: the extension must be .obj or .glb", .0.display())]
    MeshExtension(PathBuf),
    #[error(transparent)]
    Mesh(#[from] meshes::Error),
    #[error(transparent)]
    Run(#[from] RunError),
    #[error(transparent)]
    Study(#[from] StudyError),
    #[error(transparent)]
    Table(#[from] tables::Error),
    #[error(
        "--plot-deviations: nothing to plot, because the table records no light that leaves in \
        another direction than straight back; either its cells are ideal, or it was baked with \
        --deviations off"
    )]
    Straight,
    #[error("{} and {}: {reason}; bake both with the same --incidence, --azimuth, --bins and \
    --range",
        first.display(), second.display())]
    Axes {
        first: PathBuf,
        second: PathBuf,
        reason: &'static str,
    },
    #[error(transparent)]
    Output(#[from] tables::OutputError),
    #[error(transparent)]
    Terminal(#[from] tables::cli::Error),
    #[error("the tables differ by more than their errors allow")]
    Differ,
    #[error("{} does not agree with the rays through {}: they differ by more than both errors; \
    bake the table again",
        table.display(), mesh.display())]
    Retraced { table: PathBuf, mesh: PathBuf },
    #[error("{}: {source}; somebody changed the table after the bake, bake it again",
        file.display())]
    Forged {
        file: PathBuf,
        source: crate::run::Forged,
    },
    #[error("{} does not agree with the exact bake of {} made again: they differ by more than \
    counting and rounding explain; bake the table again",
        table.display(), mesh.display())]
    Rebaked { table: PathBuf, mesh: PathBuf },
    #[error("{} claims a symmetry that {} does not have, so it is wrong at the azimuths that it \
    leaves out; bake the table again",
        table.display(), mesh.display())]
    Symmetry { table: PathBuf, mesh: PathBuf },
    #[error("{}: its {attribute} \"{word}\" is not known to this version of bake; update bake, or \
    bake the table again",
        file.display())]
    Unknown {
        file: PathBuf,
        attribute: &'static str,
        word: String,
    },
    #[error("{}: {source}", file.display())]
    NoBake {
        file: PathBuf,
        source: crate::run::RetraceError,
    },
    #[error("{} does not agree with {}: {source}; bake the table again",
        table.display(), mesh.display())]
    Contradicted {
        table: PathBuf,
        mesh: PathBuf,
        source: crate::run::Contradiction,
    },
    #[error("{}: its direction_tolerance is {stated}, but between its directions it is off by \
    {found:.2e}; bake the table again", table.display())]
    Between {
        table: PathBuf,
        found: f64,
        stated: f64,
    },
    #[error(
        "this is one of {count} processes of mpirun, but this bake was built without the feature \
        mpi, or for another MPI, so each process would do the whole bake; build it with `cargo \
        install --path bake --features mpi`, or give each process its own --shard"
    )]
    NotJoined { count: usize },
    #[error(
        "rank {rank} has another mesh, other options or another version of bake than rank 0; give \
        all ranks the same"
    )]
    OtherBake { rank: usize },
    /// Failure of another rank, which prints it.
    #[error("another process failed")]
    Elsewhere,
    #[error(
        "{} (tables, counted from 0: {})",
        source,
        files.iter().map(|f| f.display().to_string()).collect::<Vec<_>>().join(", ")
    )]
    Merge {
        files: Vec<PathBuf>,
        // Boxed, because every result of the program would be as large as this variant.
        source: Box<tables::Error>,
    },
}

impl Failure {
    /// Prints the failure to standard error.
    pub(crate) fn print(&self) {
        tables::cli::fail(self);
    }

    /// Returns the exit code: 2 for wrong usage, 1 for work that failed.
    ///
    /// The code is 0 if another process failed. That process prints the failure, and its code is
    /// the code of the whole run.
    pub(crate) fn code(&self) -> u8 {
        match self {
            Failure::Elsewhere => 0,
            Failure::Study(StudyError::Run(_)) => 1,
            Failure::Run(RunError::ShardOfExact | RunError::Saved) => 2,
            Failure::Plan(_)
            | Failure::Study(_)
            | Failure::Numbers { .. }
            | Failure::NotJoined { .. }
            | Failure::Design(_)
            | Failure::MeshExtension(_)
            | Failure::Terminal(tables::cli::Error::PlotExtension(_)) => 2,
            // Faults of options that only the code of meshes can check.
            Failure::Mesh(error) => match *error.fault {
                Fault::EdgeLength { .. }
                | Fault::EdgeLengthScale { .. }
                | Fault::AzimuthZero { .. } => 2,
                _ => 1,
            },
            _ => 1,
        }
    }
}
