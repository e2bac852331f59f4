//! `bake design` of elements that are no corner cubes.

use crate::cli::cli::{DesignArgs, Failure};
use clap::Args;
use meshes::design::{Bead, Plate};
use meshes::{Fault, Mesh};

/// Options of their designs.
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

/// The mesh of the design `name`; `None` where that is a corner cube's, if any.
pub(crate) fn mesh(name: &str, args: &DesignArgs) -> Result<Option<Mesh>, Failure> {
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
