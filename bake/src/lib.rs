//! Traces the light through a retroreflective cell and stores the ray shifts in a table.
//!
//! For each direction of incidence the table says which share of the light is retroreflected, and
//! by which ray shift.
//!
//! A mesh of the crate [`meshes`] enters and a [`tables::Table`] leaves. [`Prepared`] dissects the
//! cell once. [`Plan`] checks once what is asked for. [`trace`] does the rest: by beams if all
//! facets are planes, by rays otherwise.
//!
//! ```
//! use bake::{Plan, Prepared, Request, Progress, trace};
//! use meshes::design::{Design, Shape};
//!
//! let mesh = Design::new(Shape::TriangularPair).mesh()?;
//! let cell = meshes::normalise(&mesh, "pair.obj".as_ref(), &meshes::CellOptions::default())?;
//! let prepared = Prepared::new(cell);
//! let plan = Plan::new(&Request {
//!     incidence: "0,30".into(),
//!     refractive_index: Some(1.49),
//!     ..Request::default()
//! })?;
//! let table = trace(&prepared, &plan, Progress::none())?;
//! // eta, the retroreflected share: two thirds of a cube's triangle at normal incidence.
//! assert!((table.retroreflected[[0, 0]] - 2.0 / 3.0).abs() < 1e-12);
//! assert!(table.retroreflected[[1, 0]] < table.retroreflected[[0, 0]]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Units
//!
//! Lengths are edge lengths of the cell and angles are radians, both in the cell frame. A name ends
//! in its unit if the unit is another one (`incidence_deg`, `wavelength_nm`). Degrees stand only in
//! a [`Request`] and in the axes of a table. Probabilities are per launched ray. The ray shift is
//! p' - p in the entrance plane, with the axes u along the direction of travel and v = n x u.
//!
//! # Modules
//!
//! Each folder imports only the folders before it in this list:
//!
//! - `error`: what can go wrong
//! - `geometry`: polygons, and points of the entrance
//! - `optics`: what one surface does to light
//! - `cell`: what a mesh is to light
//! - `plan`: what is asked for
//! - `rays` and `beams`: two ways to follow light
//! - `run`: the whole bake
//! - `plots`: pictures of tables
//! - `study`: speed against error
//! - `datasheet`: the data sheet of a cell
//! - `cli`: the program
#![deny(unsafe_code)]
#![warn(unreachable_pub)]

mod beams;
mod cell;
pub mod cli;
mod datasheet;
mod error;
mod geometry;
mod optics;
mod optimise;
mod plan;
mod plots;
mod rays;
mod run;
mod study;

// The public interface of this crate. The types of the options belong to the crate `tables`.
pub use cell::Prepared;
pub use datasheet::{CellFacts, Datasheet, DatasheetRequest, EtaMap, SurfaceSheet, datasheet};
pub use datasheet::{Spot, SpotDiagram, Spread, Surface, Tolerance};
pub use error::Error;
pub use optics::{metal, refractive_index};
pub use plan::Plan;
pub use plan::Request;
pub use rays::Tracer;
pub use run::Progress;
pub use run::trace;
pub use run::{Claims, Contradiction, Unchecked, claims};
pub use run::{Comparison, Difference, ExitGap};
pub use run::{Forged, consistent};
pub use run::{error_between, rebake, retrace};
pub use study::{Reached, Slope};
pub use study::{Reference, Series, Study, StudyPlan, StudyPoint, StudyRequest};

#[cfg(test)]
mod tests;
