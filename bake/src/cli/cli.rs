//! The command line of `bake`: its verbs with their help, and the exit code of each outcome.

use crate::cli::compare;
use crate::cli::datasheet;
use crate::cli::design;
use crate::cli::inspect;
use crate::cli::merge;
use crate::cli::optimise;
use crate::cli::study;
use crate::cli::trace;
use crate::cli::verify;
use crate::error::Error;
use crate::run::{Launched, start};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::ffi::OsString;
use std::process::ExitCode;
use tables::cli::{Completions, Manual, version};

/// Traces corner-cube retroreflector cells into tables of their ray shift
///
/// A table holds, for each direction of the light, the share of the rays that come straight back
/// and the distribution of their shift. The program fit reads it.
///
/// Words and formulas: fit/doc/model.md. All pages: doc/README.md.
#[derive(Debug, Parser)]
#[command(name = "bake", version, max_term_width = 100)]
#[command(after_help = "\
Example, from nothing to a picture:
  bake design triangular-pair -o pair.obj
  bake trace pair.obj -o pair.h5 --refractive-index 1.49
  bake inspect pair.h5 --plot pair.svg")]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Writes the mesh of a parametric retroreflector cell
    ///
    /// Words and formulas: fit/doc/model.md. All pages: doc/README.md.
    #[command(after_help = "\
Examples:

Pair of cubes with edges of 0.18 mm:
  bake design triangular-pair -o pair.obj --edge-length 0.18

Pair with one dihedral angle 0.1 mrad too wide:
  bake design triangular-pair -o wide.glb --edge-length 0.18 --dihedral-error-mrad 0.1,0,0

Pair whose faces bulge by 1e-4 edge lengths:
  bake design triangular-pair -o curved.obj --sag 1e-4 --segments 20

Pair with rounded edges, and flat land between the cubes:
  bake design triangular-pair -o worn.obj --edge-length 0.18 --edge-radius 0.002 \\
      --gap 0.004

Plate of slit mirrors:
  bake design plate -o plate.obj --edge-length 0.5 --depth 3

Glass beads on a mirror:
  bake design bead -o bead.obj --edge-length 0.06 --segments 24")]
    Design(design::DesignArgs),
    /// Traces the mesh of a cell into a ray-shift table
    ///
    /// The table holds, for each direction, eta (the share of the rays that come straight back),
    /// the fates of all other rays, and the distribution of the ray shift in edge lengths.
    ///
    /// Words and formulas: fit/doc/model.md. All pages: doc/README.md.
    #[command(after_help = "\
Examples:

Acrylic prisms at azimuth 30 degrees:
  bake trace pair.obj -o pair.h5 --refractive-index 1.49 --incidence 0:45:5 --azimuth 30

All azimuths in steps of 10 degrees:
  bake trace pair.obj -o all.h5 --refractive-index 1.49 --incidence 0:45:5 \\
      --azimuth full:10

Any direction, with an interpolation error below 0.005:
  bake trace pair.obj -o any.h5 --refractive-index 1.49 --incidence 0,45 --azimuth full \\
      --direction-tolerance 0.005

Aluminium mirrors and all losses, with one table for each of three colours:
  bake trace pair.obj -o pair-{nm}.h5 --refractive-index pmma \\
      --wavelength-nm 450,550,650 --losses fresnel --metal aluminium

Rough facets:
  bake trace pair.obj -o rough.h5 --refractive-index 1.49 --incidence 0:40:20 \\
      --rays 65536 --roughness 0.001

Curved faces, with the normals of the file:
  bake trace curved.obj -o curved.h5 --normals file --incidence 0,20 --rays 100000

Exit directions, within 1 mrad, of a cell that is not ideal:
  bake trace wide.glb -o wide.h5 --incidence 0:40:20 --method rays --rays 65536 \\
      --deviations 1

Plate of slit mirrors:
  bake trace plate.obj -o plate.h5 --element plate --refractive-index 1.5 --azimuth 45

Glass beads on a mirror:
  bake trace bead.obj -o bead.h5 --glass-index 1.93 --normals file \\
      --angular-tolerance 2 --incidence 0,30 --rays 65536")]
    Trace(Box<trace::TraceArgs>),
    /// Makes the data sheet of a cell, or compares two cells
    ///
    /// Eta over incidence and azimuth for ideal mirrors, metal and total reflection, entrance angles
    /// of half eta, spots of dihedral errors, and the spread of eta and MTF50 over random cells. All
    /// is computed exactly from the polygons of light, without rays and without a table.
    ///
    /// Words and formulas: fit/doc/model.md. All pages: doc/README.md.
    #[command(after_help = "\
Examples:

Page of an acrylic prism sheet, with tolerances for 0.3 mrad at 1 m:
  bake datasheet pair.obj -o pair.html --refractive-index 1.49 --unit mm \\
      --error-mrad 0.3 --distance 1000

Maps of eta as numbers:
  bake datasheet pair.obj -o pair.csv --refractive-index 1.49 --unit mm

A canted cell against an upright one:
  bake design canted -o canted.obj --edge-length 0.18 --cant-deg 7.9
  bake datasheet pair.obj canted.obj -o both.html --refractive-index 1.49 --unit mm")]
    Datasheet(Box<datasheet::DatasheetArgs>),
    /// Searches the cell whose mid-air image is best where it is wanted
    ///
    /// The MTF is that of ray shift, diffraction and dihedral errors, and the luminance is eta: both
    /// are computed exactly for each cell. The best cell is traced again by rays, and the answer
    /// says what 1 % of each parameter and 1 mrad of dihedral error cost.
    ///
    /// Words and formulas: fit/doc/model.md. All pages: doc/README.md.
    #[command(after_help = "\
Example (GOAL.toml):
  best = \"both\"                      # or \"mtf\", or \"luminance\"
  frequency_per_mm = [0.5, 1]        # in the mid-air image; each must stay visible
  least_mtf = 0.1                    # in every view along both axes; 0.1 if left out
  cells = 4000                       # to try; 10000 if left out
  [[view]]                           # every combination of its lists
  distance_mm = [300]
  incidence_deg = [0, 40]
  azimuth_deg = [0]
  weight = 1                         # against other [[view]]; 1 if left out
  [sheet]
  design = [\"canted\", \"full-cube\"]  # names of `bake design`
  edge_length_mm = { from = 0.05, to = 0.5 }
  cant_deg = { from = -10, to = 20 } # of canted cells
  truncation = 0                     # of full cubes
  refractive_index = 1.49
  dihedral_error_mrad = [0, 0, 0]
  surface = \"metal\"                  # or \"mirrors\", or \"total_reflection\"
  metal = \"aluminium\"                # may be left out
  wavelength_nm = 550

Each key of [sheet] from edge_length_mm to dihedral_error_mrad is a number or a
range. Of a front, the cell is written that is nearest to the best of both.

  bake optimise goal.toml -o best.obj --plot front.svg
  bake datasheet best.obj -o best.html --refractive-index 1.49 --unit mm")]
    Optimise(optimise::OptimiseArgs),
    /// Measures the speed and the error of every method on a mesh
    ///
    /// Bakes with every method, sampler and number of rays, and compares each table with the exact
    /// table. Without an exact table, the reference is a table of more rays.
    ///
    /// Words and formulas: fit/doc/model.md. All pages: doc/README.md.
    #[command(after_help = "\
Example: up to 16,384 rays per direction, with the curves as a picture
  bake study pair.obj --refractive-index 1.49 --azimuth 30 --rays 16384 \\
      --plot study.svg")]
    Study(Box<study::StudyArgs>),
    /// Prints what a table contains, and draws it
    ///
    /// Words and formulas: fit/doc/model.md. All pages: doc/README.md.
    #[command(after_help = "\
Examples:

Report as text, and the histograms as a picture:
  bake inspect pair.h5 --plot pair.svg

Spots into which a cell that is not ideal sends light:
  bake inspect wide.h5 --plot-deviations spots.svg")]
    Inspect(inspect::InspectArgs),
    /// Compares two tables direction by direction
    ///
    /// Eta and the histograms of the shift are compared, within the errors of both tables. The
    /// deviations are not compared. The exit code is 1 if the tables differ.
    ///
    /// Words and formulas: fit/doc/model.md. All pages: doc/README.md.
    #[command(after_help = "\
Example: do two seeds agree within their errors?
  bake compare seed1.h5 seed2.h5")]
    Compare(compare::CompareArgs),
    /// Checks a table, on its own or against the mesh of its cell
    ///
    /// Checks seal, checksums, schema and sums. With --mesh, also traces rays at some of the
    /// directions, chosen at random, and compares them with the table. The exit code is 1 if a
    /// check fails.
    ///
    /// Words and formulas: fit/doc/model.md. All pages: doc/README.md.
    #[command(after_help = "\
Examples:
  bake verify pair.h5
  bake verify pair.h5 --mesh pair.obj")]
    Verify(verify::VerifyArgs),
    /// Merges tables of one cell: shards, other directions, more rays
    ///
    /// The shards of one bake, in any order, merge to the table of the whole bake, byte for byte.
    /// Tables of its directions do so too. To add rays, bake again with the seed that follows. If
    /// the seed does not fit, the error names the one that does.
    ///
    /// Words and formulas: fit/doc/model.md. All pages: doc/README.md.
    #[command(after_help = "\
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

/// Reads the arguments; the version that `--version` shows names `commit` if there is one.
///
/// # Errors
/// Returns clap's error for wrong usage, and for help or the version, which clap prints as errors.
fn parsed(
    arguments: impl IntoIterator<Item = OsString>,
    commit: Option<&str>,
) -> Result<Cli, clap::Error> {
    let command = Cli::command().version(version(env!("CARGO_PKG_VERSION"), commit));
    Cli::from_arg_matches(&command.try_get_matches_from(arguments)?)
}

/// Runs the program on its arguments (the program's name first) and returns its exit code.
///
/// Results go to stdout, warnings, progress and errors to stderr. In a run under MPI, all ranks
/// trace, and rank 0 alone does everything else.
///
/// `commit` names the commit that was built, if the build knew it. `--version` shows it.
pub fn main(arguments: impl IntoIterator<Item = OsString>, commit: Option<&str>) -> ExitCode {
    tables::apart::start();
    let launched = Launched::from(|name| std::env::var(name).ok());
    let ranks = start(launched);
    let cli = match parsed(arguments, commit) {
        Ok(cli) => cli,
        Err(_) if !ranks.leads() => return ExitCode::SUCCESS,
        Err(error) => {
            // clap prints help to stdout with code 0, and wrong usage to stderr with code 2. A
            // closed pipe is no failure.
            let _ = error.print();
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    let done = match cli.verb {
        Verb::Trace(args) => trace::run(&args, &*ranks, launched),
        _ if !ranks.leads() => Ok(()),
        Verb::Design(args) => design::run(&args),
        Verb::Datasheet(args) => datasheet::run(&args),
        Verb::Optimise(args) => optimise::run(&args),
        Verb::Study(args) => study::run(&args),
        Verb::Inspect(args) => inspect::run(&args),
        Verb::Compare(args) => compare::run(&args),
        Verb::Verify(args) => verify::run(&args),
        Verb::Merge(args) => merge::run(&args),
        Verb::Completions(args) => args.run(Cli::command()).map_err(Error::from),
        Verb::Manual(args) => args.run(Cli::command()).map_err(Error::from),
    };
    match done {
        Ok(()) | Err(Error::Elsewhere) => ExitCode::SUCCESS,
        Err(failure) => {
            tables::cli::fail(&failure);
            ExitCode::from(failure.code())
        }
    }
}
