//! The command line: what a user types, turned into calls, and every error into one sentence and an exit code.

use crate::cli::check;
use crate::cli::element;
pub(crate) use crate::cli::failure::Failure;
use crate::cli::study;
use crate::cli::trace;

use crate::cli::{inspect, report};
use crate::plan::plan::{NormalsFrom, SceneOptions};
use crate::plots::plot;
use crate::run::ranks;
use crate::run::ranks::Launched;
use clap::{Args, Parser, Subcommand};
use glam::DVec3;
use meshes::design::{Design, Shape};
use meshes::{Cell, CellOptions, Fault, Mesh};
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use tables::{Output, Outputs};

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
        after_help = "Examples: a pair cell of 0.18 mm edges; one with a dihedral angle 0.1 mrad too wide; one whose faces bulge by 1e-4 of \
        an edge; one with rounded edges and land between the cubes; a plate of slit mirrors; glass beads on a mirror\n  \
        bake design triangular-pair -o pair.obj --edge-length 0.18\n  \
        bake design triangular-pair -o wide.glb --edge-length 0.18 --dihedral-error-mrad 0.1,0,0\n  \
        bake design triangular-pair -o curved.obj --sag 1e-4 --segments 20\n  \
        bake design triangular-pair -o worn.obj --edge-length 0.18 --edge-radius 0.002 --gap 0.004\n  \
        bake design plate -o plate.obj --edge-length 0.5 --depth 3\n  \
        bake design bead -o bead.obj --edge-length 0.06 --segments 24"
    )]
    Design(DesignArgs),
    /// Traces a mesh into a ray-shift table
    #[command(after_help = "\
Examples: acrylic prisms at azimuth 30; at all azimuths in steps of 10; anywhere within 0.005; with aluminium backs and all losses, a table a colour; \
with rough facets; curved faces by the file's normals; the exit directions of a cell that is not ideal, within 1 mrad; \
a plate of slit mirrors; glass beads
  bake trace pair.obj -o pair.h5 --refractive-index 1.49 --incidence 0:45:5 --azimuth 30
  bake trace pair.obj -o all.h5 --refractive-index 1.49 --incidence 0:45:5 --azimuth full:10
  bake trace pair.obj -o any.h5 --refractive-index 1.49 --incidence 0,45 --azimuth full --direction-tolerance 0.005
  bake trace pair.obj -o pair-{nm}.h5 --refractive-index pmma --wavelength-nm 450,550,650 --losses fresnel --metal aluminium
  bake trace pair.obj -o rough.h5 --refractive-index 1.49 --incidence 0:40:20 --rays 65536 --roughness 0.001
  bake trace curved.obj -o curved.h5 --normals file --incidence 0,20 --rays 100000
  bake trace wide.glb -o wide.h5 --incidence 0:40:20 --method rays --rays 65536 --deviations 1
  bake trace plate.obj -o plate.h5 --element plate --refractive-index 1.5 --azimuth 45
  bake trace bead.obj -o bead.h5 --glass-index 1.93 --normals file --angular-tolerance 2 --incidence 0,30 --rays 65536")]
    Trace(Box<trace::TraceArgs>),
    /// Speed against error: every method, sampler and number of rays on a mesh, against the exact table
    #[command(
        after_help = "Example: up to a million rays per direction, and the curves as a picture\n  \
        bake study pair.obj --refractive-index 1.49 --azimuth 30 --rays 1048576 --plot study.svg"
    )]
    Study(Box<study::StudyArgs>),
    /// Says what is in a table
    #[command(
        after_help = "Examples: a text report, and the histograms as a picture; the spots of a cell that is not ideal\n  \
        bake inspect pair.h5 --plot pair.svg\n  \
        bake inspect wide.h5 --plot-deviations spots.svg"
    )]
    Inspect(InspectArgs),
    /// Compares two tables direction by direction: eta and shifts, not where light goes that is off straight back
    #[command(after_help = "Example: do two seeds agree within their errors?\n  \
        bake compare seed1.h5 seed2.h5")]
    Compare(CompareArgs),
    /// Checks a table: seal, checksums, schema, sums; with the mesh, rays at a random part of its directions
    #[command(
        after_help = "Examples:\n  bake verify pair.h5\n  bake verify pair.h5 --mesh pair.obj"
    )]
    Verify(check::VerifyArgs),
    /// Puts tables of one cell together: shards of a bake, other directions, more rays
    #[command(after_help = "\
Shards of one bake, in any order, give the table of the whole bake bit for bit; so do tables of its directions. Rays are \
added by a bake with the seed that follows (the error names it).

Example: a bake in two halves, as two machines would make them
  bake trace pair.obj -o half1.h5 --method rays --rays 1000000 --shard 1/2
  bake trace pair.obj -o half2.h5 --method rays --rays 1000000 --shard 2/2
  bake merge half1.h5 half2.h5 -o pair.h5")]
    Merge(check::MergeArgs),
}

#[derive(Debug, Args)]
pub(crate) struct DesignArgs {
    /// Name of the design (see --list)
    #[arg(required_unless_present = "list")]
    name: Option<String>,
    /// Mesh to write: .obj (exact digits) or .glb
    #[arg(short, long, value_name = "FILE", required_unless_present = "list")]
    output: Option<PathBuf>,
    /// Lists the designs
    #[arg(long)]
    list: bool,
    /// Length of an edge from the apex (of an element in a lattice: its pitch), file units
    #[arg(long, value_name = "LENGTH")]
    pub(crate) edge_length: Option<f64>,
    /// Errors of the dihedral angles at edges 1, 2, 3, mrad; positive is wider than 90 degrees
    #[arg(
        long,
        value_name = "E1,E2,E3",
        value_delimiter = ',',
        allow_negative_numbers = true
    )]
    pub(crate) dihedral_error_mrad: Vec<f64>,
    /// How much lower the top is than the ideal one, as a part of its height over the apex
    #[arg(long, value_name = "PART")]
    pub(crate) truncation: Option<f64>,
    /// Angle between the sheet's normal and the cube's axis, degrees (design canted)
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub(crate) cant_deg: Option<f64>,
    /// How far the middle of each face bulges towards the light, edge lengths; its normals are written too
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) sag: Option<f64>,
    /// Facets along each edge of a face [default: 1; with --sag 40]
    #[arg(long, value_name = "N")]
    pub(crate) segments: Option<u32>,
    /// Radius that the edges from the apex are rounded with, file units
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    pub(crate) edge_radius: Option<f64>,
    /// Planar strips that a rounded edge is made of [default: 8]
    #[arg(long, value_name = "N")]
    pub(crate) strips: Option<u32>,
    /// Part of each edge that a flat facet at the apex cuts off
    #[arg(long, value_name = "PART", allow_negative_numbers = true)]
    pub(crate) apex_flat: Option<f64>,
    /// Width of the flat land between neighbouring cubes, file units (between full cubes the gap is open)
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    pub(crate) gap: Option<f64>,
    #[command(flatten)]
    pub(crate) element: element::ElementArgs,
}

/// What a user says about a cell instead of the mesh file.
#[derive(Debug, Args)]
pub(crate) struct CellArgs {
    /// Lattice vectors of a periodic cell, file units
    #[arg(long, value_name = "AX,AY,AZ,BX,BY,BZ", allow_hyphen_values = true)]
    pub(crate) lattice: Option<String>,
    /// Direction of azimuth 0 in the file's frame
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(crate) azimuth_zero: Option<String>,
    /// Length of an edge from the apex, file units [default: found from the mesh]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    pub(crate) edge_length: Option<f64>,
}

#[derive(Debug, Args)]
struct InspectArgs {
    /// Table to read
    table: PathBuf,
    /// Draws the histograms into a .png or .svg file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Draws where the light of cells goes that are not ideal into a .png or .svg file
    #[arg(long, value_name = "FILE")]
    plot_deviations: Option<PathBuf>,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
struct CompareArgs {
    /// One table
    first: PathBuf,
    /// Another of the same directions and bins
    second: PathBuf,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs the program on its arguments (the program's name first): results to stdout, the rest to stderr.
///
/// Of the ranks of an MPI run all trace, and rank 0 alone does the rest.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    tables::apart::serve();
    let launched = Launched::from(|name| std::env::var(name).ok());
    let ranks = ranks::start(launched);
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(_) if !ranks.leads() => return ExitCode::SUCCESS,
        Err(error) => {
            // Help is printed to stdout with code 0, wrong usage to stderr with code 2; a closed pipe is no failure.
            let _ = error.print();
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    let done = match cli.verb {
        Verb::Trace(args) => trace::run(&args, &*ranks, launched),
        _ if !ranks.leads() => Ok(()),
        Verb::Design(args) => design(&args),
        Verb::Study(args) => study::run(&args),
        Verb::Inspect(args) => inspect_table(&args),
        Verb::Compare(args) => compare(&args),
        Verb::Verify(args) => check::verify(&args),
        Verb::Merge(args) => check::merge(&args),
    };
    match done {
        Ok(()) | Err(Failure::Elsewhere) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.print();
            ExitCode::from(failure.code())
        }
    }
}

/// Prints a result. A closed pipe (`bake inspect ... | head`) is the reader's wish, not a failure; a full disk is one.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(Failure::Stdout(error)),
        _ => Ok(()),
    }
}

pub(crate) fn warn(warnings: &[String]) {
    for warning in warnings {
        eprintln!("warning: {warning}");
    }
}

fn design(args: &DesignArgs) -> Result<(), Failure> {
    if args.list {
        let lines =
            meshes::design::list().map(|(name, description)| format!("{name:16} {description}\n"));
        return print(&lines.collect::<String>());
    }
    // clap asks for both unless --list is there.
    let (Some(name), Some(output)) = (&args.name, &args.output) else {
        return Ok(());
    };
    if let Some(mesh) = element::mesh(name, args)? {
        return write(&mesh, output);
    }
    let mut design = Design::new(Shape::from_name(name).map_err(Failure::Design)?);
    if let Some(length) = args.edge_length {
        design.edge_length = length;
    }
    match args.dihedral_error_mrad[..] {
        [] => {}
        [a, b, c] => design.dihedral_error_rad = [a, b, c].map(|error| error * 1e-3),
        _ => {
            let text = args
                .dihedral_error_mrad
                .iter()
                .map(f64::to_string)
                .collect::<Vec<_>>()
                .join(",");
            let option = "--dihedral-error-mrad";
            return Err(Failure::Numbers {
                option,
                text,
                count: 3,
                example: "0.1,0,0",
            });
        }
    }
    if let Some(truncation) = args.truncation {
        design.truncation = truncation;
    }
    if let Some(cant_deg) = args.cant_deg {
        design.cant_rad = cant_deg.to_radians();
    }
    if let Some(sag) = args.sag {
        (design.sag, design.segments) = (sag, 40);
    }
    if let Some(segments) = args.segments {
        design.segments = segments;
    }
    design.edge_radius = args.edge_radius.unwrap_or(design.edge_radius);
    design.strips = args.strips.unwrap_or(design.strips);
    design.apex_flat = args.apex_flat.unwrap_or(design.apex_flat);
    design.gap = args.gap.unwrap_or(design.gap);
    write(&design.mesh().map_err(Failure::Design)?, output)
}

fn write(mesh: &Mesh, output: &Path) -> Result<(), Failure> {
    let bytes = match extension(output).as_str() {
        "obj" => meshes::write::obj(mesh).into_bytes(),
        "glb" if !mesh.glass.is_empty() => return Err(Failure::Design(Fault::GlassInGlb)),
        "glb" => meshes::write::glb(mesh),
        _ => return Err(Failure::MeshExtension(output.to_owned())),
    };
    Ok(Outputs::beside([]).reserve(output)?.commit(&bytes)?)
}

impl CellArgs {
    /// The cell of `mesh` as a bake with these options takes it.
    pub(crate) fn load(&self, mesh: &Path, scene: &SceneOptions) -> Result<Cell, Failure> {
        let lattice = self
            .lattice
            .as_deref()
            .map(|text| numbers::<6>("--lattice", text, "1,0,0,0,1,0"))
            .transpose()?;
        let azimuth_zero = self
            .azimuth_zero
            .as_deref()
            .map(|text| numbers::<3>("--azimuth-zero", text, "1,0,0"))
            .transpose()?;
        let options = CellOptions {
            lattice: lattice.map(|[a, b, c, d, e, f]| [DVec3::new(a, b, c), DVec3::new(d, e, f)]),
            azimuth_zero: azimuth_zero.map(DVec3::from_array),
            edge_length: self.edge_length,
            file_normals: scene.normals == NormalsFrom::File,
            glass: scene.glass_index.is_some(),
        };
        Ok(meshes::load_cell(mesh, &options)?)
    }
}

fn inspect_table(args: &InspectArgs) -> Result<(), Failure> {
    let mut outputs = Outputs::beside([args.table.as_path()]);
    let histograms = reserve_picture(args.plot.as_deref(), &mut outputs)?;
    let spots = reserve_picture(args.plot_deviations.as_deref(), &mut outputs)?;
    let table = tables::read(&args.table)?;
    if let Some((file, output)) = histograms {
        output.commit(&plot::histograms(&table, file)?)?;
    }
    if let Some((file, output)) = spots {
        output.commit(&plot::exits(&table, file)?)?;
    }
    print(&if args.json {
        inspect::json(&table)
    } else {
        inspect::text(&table)
    })
}

fn compare(args: &CompareArgs) -> Result<(), Failure> {
    let [a, b] = [tables::read(&args.first)?, tables::read(&args.second)?];
    let comparison = report::Comparison::new(&a, &b).map_err(|reason| Failure::Axes {
        first: args.first.clone(),
        second: args.second.clone(),
        reason,
    })?;
    print(&if args.json {
        comparison.json()
    } else {
        comparison.text()
    })?;
    if comparison.agrees() {
        Ok(())
    } else {
        Err(Failure::Differ)
    }
}

fn numbers<const N: usize>(
    option: &'static str,
    text: &str,
    example: &'static str,
) -> Result<[f64; N], Failure> {
    let read = |part: &str| {
        part.trim()
            .parse::<f64>()
            .ok()
            .filter(|number| number.is_finite())
    };
    let list: Option<Vec<f64>> = text.split(',').map(read).collect();
    list.and_then(|list| list.try_into().ok())
        .ok_or_else(|| Failure::Numbers {
            option,
            text: text.into(),
            count: N,
            example,
        })
}

/// Reserves the picture that was asked for; its extension is checked first.
pub(crate) fn reserve_picture<'a>(
    file: Option<&'a Path>,
    outputs: &mut Outputs,
) -> Result<Option<(&'a Path, Output)>, Failure> {
    let Some(file) = file else { return Ok(None) };
    plot::Format::of(file)?;
    Ok(Some((file, outputs.reserve(file)?)))
}

fn extension(path: &Path) -> String {
    path.extension()
        .map(|extension| extension.to_string_lossy().to_lowercase())
        .unwrap_or_default()
}
