//! Why a verb of `bake` failed: one sentence, and the exit code that it ends with.

use std::path::{Path, PathBuf};

use meshes::Fault;
use thiserror::Error;

use crate::plan::PlanError;
use crate::study::StudyError;
use crate::{plot, run};

/// Why a verb failed.
#[derive(Debug, Error)]
pub(super) enum Failure {
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
    #[error("{}: is an input of this command and would be overwritten; write to another file", .0.display())]
    Overwrites(PathBuf),
    #[error(transparent)]
    Mesh(#[from] meshes::Error),
    #[error(transparent)]
    Run(#[from] run::RunError),
    #[error(transparent)]
    Study(#[from] StudyError),
    #[error(transparent)]
    Table(#[from] tables::Error),
    #[error(transparent)]
    Plot(#[from] plot::PlotError),
    #[error("{} and {}: {reason}; bake both with the same --incidence, --azimuth, --bins and --range",
        first.display(), second.display())]
    Axes {
        first: PathBuf,
        second: PathBuf,
        reason: &'static str,
    },
    #[error("{}: cannot be written ({source}); choose another place with -o, --plot or --csv", file.display())]
    Write {
        file: PathBuf,
        source: std::io::Error,
    },
    #[error("the tables differ by more than their errors allow")]
    Differ,
}

impl Failure {
    pub(super) fn write(file: &Path, source: std::io::Error) -> Self {
        let file = file.to_path_buf();
        Failure::Write { file, source }
    }

    /// 2 for wrong usage, 1 for work that failed.
    pub(super) fn code(&self) -> u8 {
        match self {
            Failure::Study(StudyError::Run(_)) => 1,
            Failure::Plan(_)
            | Failure::Study(_)
            | Failure::Numbers { .. }
            | Failure::Design(_)
            | Failure::MeshExtension(_)
            | Failure::Plot(plot::PlotError::Extension { .. }) => 2,
            // Options that only the mesh's own code can judge.
            Failure::Mesh(error) => match *error.fault {
                Fault::EdgeLength { .. } | Fault::AzimuthZero { .. } => 2,
                _ => 1,
            },
            _ => 1,
        }
    }
}

/// Reserves the table to come, unless it would overwrite the mesh.
pub(super) fn reserve(table: &Path, mesh: &Path) -> Result<tables::Reservation, Failure> {
    match (table.canonicalize(), mesh.canonicalize()) {
        (Ok(a), Ok(b)) if a == b => Err(Failure::Overwrites(table.to_owned())),
        _ => Ok(tables::reserve(table)?),
    }
}
