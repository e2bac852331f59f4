//! Sampled light: the rays of one direction, from the entrance to their counts.
//!
//! A prepared cell, the rules and one direction enter. Integer counts by bin and by fate leave. The
//! rays are traced in four ways: one by one, down a hierarchy in groups of neighbours, as a program
//! of 64 rays side by side, and side by side with directions of their own. All ways give the same
//! result, bit for bit. This module knows no thread and no table. Its file `simd` holds the only
//! unsafe code.

mod accumulator;
mod departures;
mod entries;
mod hierarchy;
mod kernel;
mod lane;
mod path;
pub(crate) mod programs;
mod rough;
mod scene;
mod simd;
mod walls;

pub(crate) use accumulator::{Accumulator, Bins, Sums};
pub(crate) use entries::SampleRange;
pub use kernel::Tracer;
pub(crate) use kernel::{Kernel, Sheet};
#[cfg(test)]
pub(crate) use path::{Outcome, RandomNumbers, trace};
#[cfg(test)]
pub(crate) use programs::lanes::Batch;
#[cfg(test)]
pub(crate) use programs::program::{End, Program};
pub(crate) use scene::Index;
#[cfg(test)]
pub(crate) use scene::{Event, Scene};
#[cfg(test)]
pub(crate) use simd::InstructionSet;
