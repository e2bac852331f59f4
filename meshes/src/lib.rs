//! Corner-cube cells: meshes are loaded (OBJ, glTF/GLB, STL, PLY), checked, normalised and designed
//! here.
//!
//! A [`Mesh`] is the content of a file, in file units. A [`Cell`] is what rays are traced through:
//! facets in the **cell frame**, edge length 1, with the entrance, the lattice and the provenance.
//!
//! ```
//! use meshes::design::{Design, Shape};
//! let mesh = Design::new(Shape::Triangular).mesh()?;
//! let options = meshes::CellOptions::default();
//! let cell = meshes::normalise(&mesh, "triangular.obj".as_ref(), &options)?;
//! assert_eq!(cell.facets.len(), 3);
//! assert!((cell.entrance.height - 1.0 / 3f64.sqrt()).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]
#![warn(unreachable_pub)]

// Each module imports only those before it.
mod cell;
pub mod design;
mod files;
mod mesh;

// The public interface.
pub use cell::cell::CellOptions;
pub use cell::cell::{Cell, EdgeLengthFrom, Entrance};
pub use cell::normalise::{load_cell, normalise};
pub use cell::normals::Normals;
pub use files::load::load;
pub use files::{gltf, obj, ply, stl, write};
pub use mesh::error::{Error, Fault};
pub use mesh::mesh::Mesh;
