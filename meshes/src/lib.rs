//! Corner-cube cells: loading (OBJ, glTF/GLB), checking, normalising and designing meshes.
//!
//! A [`Mesh`] is what a file holds, in file units. A [`Cell`] is what the tracer needs: facets in the **cell frame**,
//! edge length 1, with the entrance, the lattice and the provenance.
//!
//! ```
//! use meshes::design::{Design, Shape};
//! let mesh = Design::new(Shape::Triangular).mesh()?;
//! let cell = meshes::normalise(&mesh, "triangular.obj".as_ref(), &meshes::CellOptions::default())?;
//! assert_eq!(cell.facets.len(), 3);
//! assert!((cell.entrance.height - 1.0 / 3f64.sqrt()).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

pub mod apex;
pub mod buffer;
pub mod cell;
pub mod check;
pub mod design;
pub mod entrance;
pub mod error;
pub mod frame;
pub mod glb;
pub mod gltf;
pub mod mesh;
pub mod normalise;
pub mod normals;
pub mod obj;
pub mod polygon;
pub mod prism;
pub mod rim;
pub mod surface;
pub mod weld;
pub mod write;

pub use cell::{Cell, Entrance};
pub use error::{Error, Fault};
pub use mesh::{Mesh, load};
pub use normalise::{CellOptions, load_cell, normalise};
pub use normals::Normals;
