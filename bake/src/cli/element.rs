//! `bake design` of elements that are no corner cubes.

use super::{DesignArgs, Failure};
use clap::Args;
use meshes::design::Plate;
use meshes::{Fault, Mesh};

/// Options of their designs.
#[derive(Debug, Args)]
pub(super) struct ElementArgs {
    /// Depth of each layer of mirrors, pitches (design plate) [default: 3]
    #[arg(long, value_name = "PITCHES", allow_negative_numbers = true)]
    depth: Option<f64>,
    /// Thickness of a mirror, pitches (design plate) [default: 0.02]
    #[arg(long, value_name = "PITCHES", allow_negative_numbers = true)]
    thickness: Option<f64>,
}

/// The mesh of the design `name`; `None` where that is a corner cube's, if any.
pub(super) fn mesh(name: &str, args: &DesignArgs) -> Result<Option<Mesh>, Failure> {
    let own = &args.element;
    let of_plates = [
        ("a depth", own.depth.is_some()),
        ("a thickness", own.thickness.is_some()),
    ];
    let of_cubes = [
        ("dihedral errors", !args.dihedral_error_mrad.is_empty()),
        ("a truncation", args.truncation.is_some()),
        ("a cant", args.cant_deg.is_some()),
        ("a sag", args.sag.is_some()),
        ("segments", args.segments.is_some()),
    ];
    let unused = |design: &str, options: &[(&'static str, bool)]| match options
        .iter()
        .find(|(_, given)| *given)
    {
        Some(&(option, _)) => Err(Failure::Design(Fault::DesignOptionUnused {
            design: design.to_owned(),
            option,
        })),
        None => Ok(()),
    };
    if name != Plate::NAME {
        return unused(name, &of_plates).map(|()| None);
    }
    unused(name, &of_cubes)?;
    let plate = Plate {
        pitch: args.edge_length.unwrap_or(1.0),
        depth: own.depth.unwrap_or(3.0),
        thickness: own.thickness.unwrap_or(0.02),
    };
    plate.mesh().map(Some).map_err(Failure::Design)
}
