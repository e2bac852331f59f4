//! Search for the nearest facet among many: for one ray, or for neighbouring rays together.

pub(crate) mod block;
pub(crate) mod bvh;
pub(crate) mod coherent;
pub(crate) mod frames;
pub(crate) mod groups;
pub(crate) mod tree;
