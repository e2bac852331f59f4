//! `bake design`: its options and what is done with them.

use crate::cli::failure::Failure;
use clap::Args;
use meshes::design::{Bead, Design, Plate, Shape};
use meshes::{Fault, Mesh};
use std::path::{Path, PathBuf};
use tables::Outputs;
use tables::cli::print;

/// Options of `bake design`.
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
    /// How far the middle of each face bulges towards the light, edge lengths; its normals are
    /// written too
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
    /// Width of the flat land between neighbouring cubes, file units (between full cubes the gap is
    /// open)
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    pub(crate) gap: Option<f64>,
    #[command(flatten)]
    pub(crate) element: ElementArgs,
}

/// Options of the designs that are no corner cubes.
#[derive(Debug, Args)]
pub(crate) struct ElementArgs {
    /// Depth of each layer of mirrors, pitches (design plate) [default: 3]
    #[arg(long, value_name = "PITCHES", allow_negative_numbers = true)]
    depth: Option<f64>,
    /// Thickness of a mirror, pitches (design plate) [default: 0.02]
    #[arg(long, value_name = "PITCHES", allow_negative_numbers = true)]
    thickness: Option<f64>,
    /// Diameter of a bead, pitches (design bead) [default: 0.95]
    #[arg(long, value_name = "PITCHES", allow_negative_numbers = true)]
    diameter: Option<f64>,
}

/// Runs `bake design`.
pub(crate) fn run(args: &DesignArgs) -> Result<(), Failure> {
    if args.list {
        let lines =
            meshes::design::list().map(|(name, description)| format!("{name:16} {description}\n"));
        return Ok(print(&lines.collect::<String>())?);
    }
    // clap asks for both unless --list is there.
    let (Some(name), Some(output)) = (&args.name, &args.output) else {
        return Ok(());
    };
    if let Some(mesh) = element(name, args)? {
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

/// The mesh of the design `name`; `None` where that is a corner cube's, if any.
fn element(name: &str, args: &DesignArgs) -> Result<Option<Mesh>, Failure> {
    let own = &args.element;
    let pitch = args.edge_length.unwrap_or(1.0);
    let of_plates = [
        ("a depth", own.depth.is_some()),
        ("a thickness", own.thickness.is_some()),
    ];
    let of_beads = [("a diameter", own.diameter.is_some())];
    let of_cubes = [
        ("dihedral errors", !args.dihedral_error_mrad.is_empty()),
        ("a truncation", args.truncation.is_some()),
        ("a cant", args.cant_deg.is_some()),
        ("a sag", args.sag.is_some()),
        ("an edge radius", args.edge_radius.is_some()),
        ("strips", args.strips.is_some()),
        ("a flat apex", args.apex_flat.is_some()),
        ("a gap", args.gap.is_some()),
    ];
    let of_facets = [("segments", args.segments.is_some())];
    let refuse = |others: &[&[(&'static str, bool)]]| {
        let named = others.iter().copied().flatten().find(|(_, given)| *given);
        named.map_or(Ok(()), |&(option, _)| {
            Err(Failure::Design(Fault::DesignOptionUnused {
                design: name.to_owned(),
                option,
            }))
        })
    };
    let mesh = match name {
        Plate::NAME => {
            refuse(&[&of_cubes, &of_facets, &of_beads])?;
            Plate {
                pitch,
                depth: own.depth.unwrap_or(3.0),
                thickness: own.thickness.unwrap_or(0.02),
            }
            .mesh()
        }
        Bead::NAME => {
            refuse(&[&of_cubes, &of_plates])?;
            Bead {
                pitch,
                diameter: own.diameter.unwrap_or(0.95),
                segments: args.segments.unwrap_or(40),
            }
            .mesh()
        }
        _ => return refuse(&[&of_plates, &of_beads]).map(|()| None),
    };
    mesh.map(Some).map_err(Failure::Design)
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

fn extension(path: &Path) -> String {
    path.extension()
        .map(|extension| extension.to_string_lossy().to_lowercase())
        .unwrap_or_default()
}
