//! Ray-shift tables in memory: axes, counts, fates, polygons, deviations, provenance, and rules.
//!
//! Counts or polygons enter. A [`table::Table`] leaves, and all of its numbers follow from them.

pub(crate) mod axes;
pub(crate) mod check;
pub(crate) mod counts;
pub mod deviation;
pub(crate) mod exact;
pub(crate) mod fate;
pub(crate) mod flat;
pub mod polygon;
pub(crate) mod provenance;
pub(crate) mod shards;
pub(crate) mod symmetry;
pub(crate) mod table;
