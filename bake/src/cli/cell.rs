//! The cell of a mesh file, with what a user says about it on the command line.

use crate::cli::failure::Failure;
use clap::Args;
use glam::DVec3;
use meshes::{Cell, CellOptions};
use std::path::Path;
use tables::options::{NormalsFrom, SceneOptions};

/// What a user says about a cell instead of the mesh file.
#[derive(Debug, Args)]
pub(crate) struct CellArgs {
    /// Lattice vectors of a periodic cell, file units
    #[arg(long, value_name = "AX,AY,AZ,BX,BY,BZ", allow_hyphen_values = true)]
    pub(crate) lattice: Option<String>,
    /// Incidence of azimuth 0 in the file's frame
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(crate) azimuth_zero: Option<String>,
    /// Length of an edge from the apex, file units [default: found from the mesh]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    pub(crate) edge_length: Option<f64>,
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
