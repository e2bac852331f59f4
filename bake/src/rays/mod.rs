//! Sampled light: the rays of one direction, from the entrance to their counts.
//!
//! A prepared cell, the rules and one direction enter. Integer counts by bin and by fate leave. The
//! rays are traced in four ways: one by one, down a hierarchy in groups of neighbours, as a program
//! of 64 rays side by side, and side by side with directions of their own. All ways give the same
//! result, bit for bit. This module knows no thread and no table. Its file `simd` holds the only
//! unsafe code.

mod accumulator;
mod block;
mod bvh;
mod coherent;
mod departures;
mod entries;
mod exits;
mod frames;
mod groups;
mod kernel;
mod lane;
pub(crate) mod lanes;
mod path;
mod program;
mod region;
mod rough;
mod scene;
mod scratch;
mod simd;
mod tree;

pub(crate) use accumulator::Bins;
pub(crate) use accumulator::{Accumulator, Sums};
pub(crate) use entries::SampleRange;
pub(crate) use kernel::Kernel;
pub(crate) use kernel::Sheet;
pub use kernel::Tracer;
#[cfg(test)]
pub(crate) use lanes::Batch;
#[cfg(test)]
pub(crate) use path::{Outcome, RandomNumbers, trace};
#[cfg(test)]
pub(crate) use program::{End, Program};
pub(crate) use scene::Index;
#[cfg(test)]
pub(crate) use scene::{Event, Scene};
#[cfg(test)]
pub(crate) use simd::InstructionSet;
