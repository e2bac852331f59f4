//! The command line: what a user types, turned into calls, and every error into one sentence and an
//! exit code.

use crate::cli::compare;
use crate::cli::design;
use crate::cli::failure::Failure;
use crate::cli::inspect;
use crate::cli::merge;
use crate::cli::study;
use crate::cli::trace;
use crate::cli::verify;
use crate::run::{Launched, start};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::ffi::OsString;
use std::process::ExitCode;
use tables::cli::{Completions, Manual, version};

/// Traces a corner-cube mesh into a ray-shift table.
#[derive(Debug, Parser)]
#[command(name = "bake", version, max_term_width = 100)]
#[command(after_help = "Example, from nothing to a picture:\n  \
    bake design triangular-pair -o pair.obj\n  \
    bake trace pair.obj -o pair.h5 --refractive-index 1.49\n  \
    bake inspect pair.h5 --plot pair.png")]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Writes the mesh of a parametric corner-cube cell
    #[command(
        after_help = "Examples: a pair cell of 0.18 mm edges; one with a dihedral angle 0.1 mrad \
        too wide; one whose faces bulge by 1e-4 of \
        an edge; one with rounded edges and land between the cubes; a plate of slit mirrors; \
        glass beads on a mirror\n  \
        bake design triangular-pair -o pair.obj --edge-length 0.18\n  \
        bake design triangular-pair -o wide.glb --edge-length 0.18 --dihedral-error-mrad \
        0.1,0,0\n  \
        bake design triangular-pair -o curved.obj --sag 1e-4 --segments 20\n  \
        bake design triangular-pair -o worn.obj --edge-length 0.18 --edge-radius 0.002 --gap \
        0.004\n  \
        bake design plate -o plate.obj --edge-length 0.5 --depth 3\n  \
        bake design bead -o bead.obj --edge-length 0.06 --segments 24"
    )]
    Design(design::DesignArgs),
    /// Traces a mesh into a ray-shift table
    #[command(after_help = "\
Examples: acrylic prisms at azimuth 30; at all azimuths in steps of 10; anywhere within 0.005; \
with aluminium backs and all losses, a table a colour; \
with rough facets; curved faces by the file's normals; the exit directions of a cell that is not \
ideal, within 1 mrad; \
a plate of slit mirrors; glass beads
  bake trace pair.obj -o pair.h5 --refractive-index 1.49 --incidence 0:45:5 --azimuth 30
  bake trace pair.obj -o all.h5 --refractive-index 1.49 --incidence 0:45:5 --azimuth full:10
  bake trace pair.obj -o any.h5 --refractive-index 1.49 --incidence 0,45 --azimuth full \
  --direction-tolerance 0.005
  bake trace pair.obj -o pair-{nm}.h5 --refractive-index pmma --wavelength-nm 450,550,650 \
  --losses fresnel --metal aluminium
  bake trace pair.obj -o rough.h5 --refractive-index 1.49 --incidence 0:40:20 --rays 65536 \
  --roughness 0.001
  bake trace curved.obj -o curved.h5 --normals file --incidence 0,20 --rays 100000
  bake trace wide.glb -o wide.h5 --incidence 0:40:20 --method rays --rays 65536 --deviations 1
  bake trace plate.obj -o plate.h5 --element plate --refractive-index 1.5 --azimuth 45
  bake trace bead.obj -o bead.h5 --glass-index 1.93 --normals file --angular-tolerance 2 \
  --incidence 0,30 --rays 65536")]
    Trace(Box<trace::TraceArgs>),
    /// Speed against error: every method, sampler and number of rays on a mesh, against the exact
    /// table
    #[command(
        after_help = "Example: up to a million rays per direction, and the curves as a picture\n  \
        bake study pair.obj --refractive-index 1.49 --azimuth 30 --rays 1048576 --plot study.svg"
    )]
    Study(Box<study::StudyArgs>),
    /// Says what is in a table
    #[command(
        after_help = "Examples: a text report, and the histograms as a picture; the spots of a \
        cell that is not ideal\n  \
        bake inspect pair.h5 --plot pair.svg\n  \
        bake inspect wide.h5 --plot-deviations spots.svg"
    )]
    Inspect(inspect::InspectArgs),
    /// Compares two tables direction by direction: eta and shifts, not where light goes that is off
    /// straight back
    #[command(after_help = "Example: do two seeds agree within their errors?\n  \
        bake compare seed1.h5 seed2.h5")]
    Compare(compare::CompareArgs),
    /// Checks a table: seal, checksums, schema, sums; with the mesh, rays at a random part of its
    /// directions
    #[command(
        after_help = "Examples:\n  bake verify pair.h5\n  bake verify pair.h5 --mesh pair.obj"
    )]
    Verify(verify::VerifyArgs),
    /// Puts tables of one cell together: shards of a bake, other directions, more rays
    #[command(after_help = "\
Shards of one bake, in any order, give the table of the whole bake bit for bit; so do tables of \
its directions. Rays are \
added by a bake with the seed that follows (the error names it).

Example: a bake in two halves, as two machines would make them
  bake trace pair.obj -o half1.h5 --method rays --rays 1000000 --shard 1/2
  bake trace pair.obj -o half2.h5 --method rays --rays 1000000 --shard 2/2
  bake merge half1.h5 half2.h5 -o pair.h5")]
    Merge(merge::MergeArgs),
    #[command(after_help = "Example: for the shell that is open\n  bake completions bash")]
    Completions(Completions),
    #[command(
        after_help = "Example: read them with man -l pages/bake-trace.1\n  bake manual pages"
    )]
    Manual(Manual),
}

/// The arguments, read.
fn parsed(
    arguments: impl IntoIterator<Item = OsString>,
    commit: Option<&str>,
) -> Result<Cli, clap::Error> {
    let command = Cli::command().version(version(env!("CARGO_PKG_VERSION"), commit));
    Cli::from_arg_matches(&command.try_get_matches_from(arguments)?)
}

/// Runs the program on its arguments (the program's name first): results to stdout, the rest to
/// stderr.
///
/// Of the ranks of an MPI run all trace, and rank 0 alone does the rest.
///
/// `commit` names the commit that was built, where the build was told; `--version` shows it.
pub fn main(arguments: impl IntoIterator<Item = OsString>, commit: Option<&str>) -> ExitCode {
    tables::apart::serve();
    let launched = Launched::from(|name| std::env::var(name).ok());
    let ranks = start::start(launched);
    let cli = match parsed(arguments, commit) {
        Ok(cli) => cli,
        Err(_) if !ranks.leads() => return ExitCode::SUCCESS,
        Err(error) => {
            // Help is printed to stdout with code 0, wrong usage to stderr with code 2; a closed
            // pipe is no failure.
            let _ = error.print();
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    let done = match cli.verb {
        Verb::Trace(args) => trace::run(&args, &*ranks, launched),
        _ if !ranks.leads() => Ok(()),
        Verb::Design(args) => design::run(&args),
        Verb::Study(args) => study::run(&args),
        Verb::Inspect(args) => inspect::run(&args),
        Verb::Compare(args) => compare::run(&args),
        Verb::Verify(args) => verify::run(&args),
        Verb::Merge(args) => merge::run(&args),
        Verb::Completions(args) => args.run(Cli::command()).map_err(Failure::from),
        Verb::Manual(args) => args.run(Cli::command()).map_err(Failure::from),
    };
    match done {
        Ok(()) | Err(Failure::Elsewhere) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.print();
            ExitCode::from(failure.code())
        }
    }
}
