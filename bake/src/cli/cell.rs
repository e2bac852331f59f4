//! Options that describe the cell of a mesh file, and the cell that they make.

use crate::error::Error;
use crate::optics::material;
use clap::Args;
use glam::DVec3;
use meshes::{Cell, CellOptions, Mesh};
use std::path::Path;
use tables::cli::number;
use tables::options::{Front, NormalsFrom, SceneOptions};

/// Options that say about a cell what the mesh file does not, or override it.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub(crate) struct CellArgs {
    /// Edge length, file units [default: found from the mesh]
    ///
    /// The length of a cube's edge from its apex. It is the unit of all lengths in the table. When
    /// a table is verified, edge length and azimuth 0 are those of the table by default.
    #[arg(long, value_parser = number, value_name = "LENGTH")]
    pub(crate) edge_length: Option<f64>,
    /// Direction of azimuth 0 in the frame of the file
    ///
    /// It may have any length. Its part in the plane of the sheet counts. Without this option and
    /// without a direction in the file, it is the first edge of the first cube.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(crate) azimuth_zero: Option<String>,
    /// Lattice vectors of a periodic cell, file units
    ///
    /// They override the vectors in the file. A cell whose rim is not planar needs them. With
    /// --front trapped the sides of a parallelogram are the lattice vectors by default.
    #[arg(long, value_name = "AX,AY,AZ,BX,BY,BZ", allow_hyphen_values = true)]
    pub(crate) lattice: Option<String>,
    /// Unit of the file's lengths, which the table records
    ///
    /// No number depends on it: all lengths of a table are in edge lengths. Most formats, such as
    /// STL, do not say their unit.
    #[arg(long, value_name = "UNIT", value_parser = ["nm", "um", "mm", "cm", "m", "in"])]
    pub(crate) unit: Option<String>,
}

impl CellArgs {
    /// Loads the cell of the file `mesh` with these options and those of the `scene`.
    ///
    /// # Errors
    /// Returns an [`Error`] if an option is no list of numbers, or if the file cannot be read or is
    /// no cell.
    pub(crate) fn load(&self, mesh: &Path, scene: &SceneOptions) -> Result<Cell, Error> {
        self.with_unit(meshes::load_cell(mesh, &self.options(scene)?))
    }

    /// Makes the cell of a mesh in memory; `name` is its name for messages.
    ///
    /// # Errors
    /// Fails as [`CellArgs::load`] does.
    pub(super) fn of_mesh(
        &self,
        mesh: &Mesh,
        name: &Path,
        scene: &SceneOptions,
    ) -> Result<Cell, Error> {
        self.with_unit(meshes::normalise(mesh, name, &self.options(scene)?))
    }

    /// Returns a cell with the unit that was given.
    fn with_unit(&self, cell: Result<Cell, meshes::Error>) -> Result<Cell, Error> {
        let unit = self.unit.clone();
        Ok(Cell { unit, ..cell? })
    }

    /// Returns these options and those of the `scene` as options of a cell.
    fn options(&self, scene: &SceneOptions) -> Result<CellOptions, Error> {
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
        Ok(CellOptions {
            lattice: lattice.map(|[a, b, c, d, e, f]| [DVec3::new(a, b, c), DVec3::new(d, e, f)]),
            azimuth_zero: azimuth_zero.map(DVec3::from_array),
            edge_length: self.edge_length,
            file_normals: scene.normals == NormalsFrom::File,
            glass: scene.glass_index.is_some(),
            periodic: scene.front == Front::Trapped,
        })
    }
}

/// Option for the refractive index of the sheet.
#[derive(Debug, Args)]
pub(crate) struct IndexArgs {
    /// Refractive index behind the front face [default: the file's, else 1]
    ///
    /// A number from 1 to 10; a material: pmma (acrylic), polycarbonate or bk7; or pairs nm:index
    /// such as 450:1.50,650:1.49. A material and pairs hold at --wavelength-nm.
    #[arg(long, value_name = "M", allow_hyphen_values = true)]
    refractive_index: Option<String>,
}

impl IndexArgs {
    /// Returns the index at a wavelength in nm, where it was given.
    ///
    /// # Errors
    /// Returns [`Error::Usage`] if it cannot be read, or is not known at this wavelength.
    pub(crate) fn at(&self, wavelength_nm: Option<f64>) -> Result<Option<f64>, Error> {
        let text = self.refractive_index.as_deref();
        text.map(|text| material::refractive_index(text, wavelength_nm))
            .transpose()
    }
}

/// Reads `N` finite numbers separated by commas; an error names the option and an example.
fn numbers<const N: usize>(option: &str, text: &str, example: &str) -> Result<[f64; N], Error> {
    let read = |part: &str| {
        part.trim()
            .parse::<f64>()
            .ok()
            .filter(|number| number.is_finite())
    };
    let list: Option<Vec<f64>> = text.split(',').map(read).collect();
    list.and_then(|list| list.try_into().ok()).ok_or_else(|| {
        Error::Usage(format!(
            "{option} {text}: give {N} numbers separated by commas, such as {example}"
        ))
    })
}
