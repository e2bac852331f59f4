//! Traces rays through a corner-cube cell into a ray-shift table.
//!
//! A sample (seed, index) becomes a point of the entrance ([`launch`]), a ray, a path ([`path`]) and a count
//! ([`tally`]); [`run`] does it for all directions on all threads. Everything happens in the cell frame, in edge
//! lengths and radians; degrees exist at the door only ([`plan`]).
#![deny(unsafe_code)]

pub mod bodies;
pub mod bundle;
pub mod bvh;
pub mod cli;
pub mod directions;
pub mod element;
pub mod exact;
pub mod inspect;
pub mod kernel;
pub mod lanes;
pub mod launch;
pub mod light;
pub mod material;
pub mod optics;
pub mod packet;
pub mod path;
pub mod plan;
pub mod plot;
pub mod polygon;
pub mod program;
pub mod progress;
pub mod provenance;
pub mod ranks;
pub mod ray;
pub mod report;
pub mod retrace;
pub mod roughness;
pub mod run;
pub mod saves;
pub mod scene;
pub mod sequence;
pub mod sheet;
pub mod simd;
pub mod study;
pub mod symmetry;
pub mod tally;
pub mod triangle;
mod work;
#[cfg(feature = "mpi")]
pub mod world;
