//! A ray-shift table in memory: axes, counts, fates, polygons, deviations, provenance, and the
//! rules that they obey.
//!
//! Counts or polygons enter; a [`table::Table`] leaves whose every number follows from them. It
//! touches the options that its provenance states, and no other room.

pub(crate) mod axes;
pub(crate) mod check;
pub(crate) mod counts;
pub mod deviation;
pub(crate) mod exact;
pub(crate) mod fate;
pub(crate) mod flat;
pub(crate) mod invalid;
pub mod polygon;
pub(crate) mod provenance;
pub(crate) mod shards;
pub(crate) mod symmetry;
pub(crate) mod table;
