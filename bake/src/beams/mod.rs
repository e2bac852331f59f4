//! Light as polygons: the exact distribution of the ray shifts of cells with planar facets.
//!
//! A [`crate::cell::ExactCell`], the rules and directions enter. Polygons with their maps, their
//! fates and exact bins leave. No samples are taken.

mod beam;
mod bins;
mod candidate;
pub(crate) mod exact;
mod mean;
mod paths;
mod returned;
mod view;

pub(crate) use exact::spread;
#[cfg(test)]
pub(crate) use exact::{Share, bake, prepare};
pub(crate) use returned::Returned;
