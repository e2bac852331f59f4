//! The facts of a mesh that matter to light, each found once: its bodies, its planar facets and
//! their openings, its symmetry.
//!
//! A [`meshes::Cell`] enters. A [`prepared::Prepared`] leaves, which all modules above ask instead
//! of the mesh. It knows no direction of incidence.

mod bodies;
mod body;
mod planar;
mod planes;
mod prepared;
mod rim;
mod symmetry;

#[cfg(test)]
pub(crate) use bodies::Kind;
pub(crate) use bodies::Whole;
pub(crate) use body::{Body, Part};
pub(crate) use planar::ExactCell;
pub(crate) use planar::NO_PLANES;
pub(crate) use planes::PlanarFacet;
pub use prepared::Prepared;
pub(crate) use prepared::{MEAN_ERROR, PROGRAM_FACETS, SMALL};
