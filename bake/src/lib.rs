//! Traces rays through a corner-cube cell into a ray-shift table.
//!
//! A sample (seed, index) becomes a point of the entrance ([`launch`]), a ray, a path ([`path`]) and a count
//! ([`tally`]); [`run`] does it for all directions on all threads. Everything happens in the cell frame, in edge
//! lengths and radians; degrees exist at the door only ([`plan`]).
#![deny(unsafe_code)]

pub mod beams;
pub mod cell;
pub mod cli;
pub mod geometry;
pub mod optics;
pub mod plan;
pub mod plots;
pub mod rays;
pub mod run;
pub mod samples;
pub mod study;
