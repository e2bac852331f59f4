//! Bakes a corner-cube cell into a table of ray shifts: where the light comes back that the cell
//! returns, for each direction of incidence.
//!
//! A mesh of the crate [`meshes`] enters; a [`tables::Table`] leaves. The cell is dissected once
//! ([`Prepared`]), what is asked for is checked once ([`Plan`]), and [`trace`] does the rest, by
//! beams where facets are planes and by rays elsewhere.
//!
//! ```
//! use bake::{Plan, Prepared, Request, Watch, trace};
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
//! let table = trace(&prepared, &plan, Watch::none())?;
//! // eta, the retroreflected fraction: two thirds of a cube's triangle, seen straight on.
//! assert!((table.retroreflected[[0, 0]] - 2.0 / 3.0).abs() < 1e-12);
//! assert!(table.retroreflected[[1, 0]] < table.retroreflected[[0, 0]]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Units
//!
//! Lengths are edge lengths of the cell, angles radians, both in the cell frame; names of other
//! units say so (`incidence_deg`, `wavelength_nm`). Degrees exist at the door only: in a
//! [`Request`] and in the axes of a table. Probabilities are per launched ray. The shift is p' - p
//! in the entrance plane, u along the direction of travel, v = n x u.
//!
//! # Rooms
//!
//! Each folder imports only those before it: `geometry` (polygons), `samples` (points of the
//! entrance), `optics` (what one surface does), `cell` (what a mesh is), `plan` (what is asked),
//! `rays` and `beams` (how light is followed), `run` (the bake), `plots`, `study` (speed against
//! error), `cli` (the program).
#![deny(unsafe_code)]
#![warn(unreachable_pub)]

mod beams;
mod cell;
pub mod cli;
mod geometry;
mod optics;
mod plan;
mod plots;
mod rays;
mod run;
mod samples;
mod study;

// What others may use. The options themselves are types of `tables`.
pub use cell::ExactError;
pub use cell::Prepared;
pub use optics::{MaterialError, metal, refractive_index};
pub use plan::Plan;
pub use plan::PlanError;
pub use plan::Request;
pub use rays::Tracer;
pub use run::RunError;
pub use run::Watch;
pub use run::trace;
pub use run::{Comparison, Row};
pub use run::{RetraceError, retrace};
pub use study::{Point, Reference, Series, Study, StudyError, StudyPlan, StudyRequest};
pub use study::{Reached, Slope};

#[cfg(test)]
mod tests;
