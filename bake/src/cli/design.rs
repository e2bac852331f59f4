//! `bake design`: reads its options and writes the mesh of a design.

use crate::error::Error;
use crate::plan::heading;
use clap::Args;
use meshes::design::{Bead, Design, Plate, Shape};
use meshes::{Fault, Mesh};
use std::path::{Path, PathBuf};
use tables::Outputs;
use tables::cli::{number, print, whole};

/// Options of `bake design`.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub(crate) struct DesignArgs {
    /// Name of the design; --list prints all names
    #[arg(required_unless_present = "list")]
    name: Option<String>,
    /// Mesh to write: .obj (exact digits) or .glb
    #[arg(short, long, value_name = "FILE", required_unless_present = "list")]
    output: Option<PathBuf>,
    /// Lists the designs
    #[arg(long)]
    list: bool,
    /// Edge length of a cube, from its apex, file units [default: 3]
    ///
    /// For a plate or beads it is the pitch, that is the distance from one element to the next, 1
    /// by default.
    #[arg(long, value_parser = number, value_name = "LENGTH")]
    pub(crate) edge_length: Option<f64>,
    /// Part by which the top is lower than the ideal one
    ///
    /// The unit is the height of the ideal top above the apex. From 0 to below 1; of a full cube
    /// below 0.5.
    #[arg(long, value_parser = number, value_name = "PART", help_heading = heading::SHAPE)]
    pub(crate) truncation: Option<f64>,
    /// Angle between the sheet's normal and the cube's axis, degrees
    ///
    /// For the design canted only, 8.59 degrees (0.15 rad) by default. A positive angle leans
    /// towards edge 1.
    #[arg(long, value_parser = number, value_name = "DEG", help_heading = heading::SHAPE)]
    pub(crate) cant_deg: Option<f64>,
    /// Width of the flat land between neighbouring cubes, file units
    ///
    /// Between full cubes the gap is open.
    #[arg(long, value_parser = number, value_name = "LENGTH", help_heading = heading::SHAPE)]
    pub(crate) gap: Option<f64>,
    /// Errors of the dihedral angles at edges 1, 2, 3, mrad
    ///
    /// A positive error makes the angle wider than 90 degrees.
    #[arg(
        long,
        value_name = "E1,E2,E3",
        value_delimiter = ',',
        value_parser = number,
        allow_hyphen_values = true,
        help_heading = heading::IMPERFECT
    )]
    pub(crate) dihedral_error_mrad: Vec<f64>,
    /// Bulge of each face in its middle, edge lengths
    ///
    /// A positive bulge is towards the light. The normals of the curved faces are written too.
    #[arg(long, value_parser = number, value_name = "S", help_heading = heading::IMPERFECT)]
    pub(crate) sag: Option<f64>,
    /// Facets along an edge of a face [default: 1; 40 with --sag]
    ///
    /// For the design bead it is the number of facets along each edge of the octahedron that
    /// becomes the sphere, 40 by default.
    #[arg(
        long,
        value_name = "N",
        help_heading = heading::IMPERFECT,
        value_parser = whole::<u32>(0..)
    )]
    pub(crate) segments: Option<u32>,
    /// Radius of the rounded edges from the apex, file units
    #[arg(long, value_parser = number, value_name = "LENGTH", help_heading = heading::IMPERFECT)]
    pub(crate) edge_radius: Option<f64>,
    /// Planar strips of each rounded edge [default: 8]
    #[arg(
        long,
        value_name = "N",
        help_heading = heading::IMPERFECT,
        value_parser = whole::<u32>(0..)
    )]
    pub(crate) strips: Option<u32>,
    /// Part of each edge that a flat facet at the apex cuts off
    #[arg(long, value_parser = number, value_name = "PART", help_heading = heading::IMPERFECT)]
    pub(crate) apex_flat: Option<f64>,
    #[command(flatten, next_help_heading = heading::ELEMENT)]
    pub(crate) element: ElementArgs,
}

/// Options of the designs that are no corner cubes.
#[derive(Debug, Args)]
pub(crate) struct ElementArgs {
    /// Depth of each layer of mirrors, pitches (design plate) [default: 3]
    #[arg(long, value_parser = number, value_name = "PITCHES")]
    depth: Option<f64>,
    /// Thickness of a mirror, pitches (design plate) [default: 0.02]
    #[arg(long, value_parser = number, value_name = "PITCHES")]
    thickness: Option<f64>,
    /// Diameter of a bead, pitches (design bead) [default: 0.95]
    #[arg(long, value_parser = number, value_name = "PITCHES")]
    diameter: Option<f64>,
}

/// Runs `bake design`: writes a mesh, or prints the list of designs.
pub(crate) fn run(args: &DesignArgs) -> Result<(), Error> {
    if args.list {
        let lines =
            meshes::design::list().map(|(name, description)| format!("{name:16} {description}\n"));
        return Ok(print(&lines.collect::<String>())?);
    }
    // clap requires both unless --list is given.
    let (Some(name), Some(output)) = (&args.name, &args.output) else {
        return Ok(());
    };
    write(&made(name, args)?, output)
}

/// Makes the error of an option of a design.
fn wrong(fault: Fault) -> Error {
    Error::Usage(fault.to_string())
}

/// Makes the mesh of the design with this name.
///
/// # Errors
/// Returns [`Error::Usage`] if there is no such design, if an option has no meaning for it or is out
/// of range, or if the dihedral errors are not three.
fn made(name: &str, args: &DesignArgs) -> Result<Mesh, Error> {
    if let Some(mesh) = element(name, args)? {
        return Ok(mesh);
    }
    let mut design = Design::new(Shape::from_name(name).map_err(wrong)?);
    if let Some(length) = args.edge_length {
        design.edge_length = length;
    }
    match args.dihedral_error_mrad[..] {
        [] => {}
        [a, b, c] => design.dihedral_error_rad = [a, b, c].map(|error| error * 1e-3),
        _ => {
            let given = args.dihedral_error_mrad.iter().map(f64::to_string);
            return Err(Error::Usage(format!(
                "--dihedral-error-mrad {}: give 3 numbers separated by commas, such as 0.1,0,0",
                given.collect::<Vec<_>>().join(",")
            )));
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
    design.mesh().map_err(wrong)
}

/// Returns the mesh of the design that is named, as if it had been written to an OBJ file and read
/// again.
///
/// # Errors
/// Fails as [`run`] does, but for the file.
pub(super) fn read_back(args: &DesignArgs) -> Result<Mesh, Error> {
    let name = args.name.as_deref().unwrap_or_default();
    as_read(&made(name, args)?)
}

/// Returns a mesh as it is read from the OBJ file that it would be written to.
///
/// # Errors
/// Returns [`Error::Usage`] if it cannot be read.
pub(super) fn as_read(mesh: &Mesh) -> Result<Mesh, Error> {
    let text = meshes::write::obj(mesh);
    meshes::obj::parse(text.as_bytes()).map_err(wrong)
}

/// Makes the mesh of a plate or of beads, if `name` is one of these designs.
///
/// Returns `None` for any other name, which is left to [`Shape::from_name`].
///
/// # Errors
/// Returns [`Error::Usage`] if an option has no meaning for the design, or is out of range.
fn element(name: &str, args: &DesignArgs) -> Result<Option<Mesh>, Error> {
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
            Err(wrong(Fault::DesignOptionUnused {
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
    mesh.map(Some).map_err(wrong)
}

/// Writes a mesh in the format that the extension of `output` names.
pub(super) fn write(mesh: &Mesh, output: &Path) -> Result<(), Error> {
    let bytes = Format::of(output)?.bytes(mesh)?;
    Ok(Outputs::beside([]).reserve(output)?.commit(&bytes)?)
}

/// Format of a mesh that is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Obj,
    Glb,
}

impl Format {
    /// Returns the format that the extension of `output` names.
    pub(super) fn of(output: &Path) -> Result<Format, Error> {
        let extension = output.extension().unwrap_or_default();
        match extension.to_string_lossy().to_lowercase().as_str() {
            "obj" => Ok(Format::Obj),
            "glb" => Ok(Format::Glb),
            _ => Err(Error::Usage(format!(
                "-o {}: the extension must be .obj or .glb",
                output.display()
            ))),
        }
    }

    /// Returns the file of a mesh.
    pub(super) fn bytes(self, mesh: &Mesh) -> Result<Vec<u8>, Error> {
        match self {
            Format::Obj => Ok(meshes::write::obj(mesh).into_bytes()),
            Format::Glb if !mesh.glass.is_empty() => Err(wrong(Fault::GlassInGlb)),
            Format::Glb => Ok(meshes::write::glb(mesh)),
        }
    }
}
