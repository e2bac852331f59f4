//! Reasons why tables cannot be merged. Indices are positions in the given list, from 0.

use crate::table::shards::Shards;

/// Reason why tables cannot be merged.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Mismatch {
    /// Empty list of tables.
    #[error("no table to merge; name at least one")]
    Empty,
    /// Field of the provenance or the axes that differs between tables.
    #[error(
        "{field} of table {index} is {found}, that of the first is {expected}; merge tables of \
        one design and method only"
    )]
    Field {
        /// Name of the field, as in the file.
        field: &'static str,
        /// Index of the table.
        index: usize,
        /// Value in the first table.
        expected: String,
        /// Value in this table.
        found: String,
    },
    /// Rays that two tables both hold.
    #[error(
        "tables {first} and {second} both hold {what} at direction {direction:?}, which would be \
        counted twice; leave one of them out, or bake it with another --seed"
    )]
    Overlap {
        /// Index of one table.
        first: usize,
        /// Index of the other table.
        second: usize,
        /// Rays that both hold: of a seed, of a shard, or the exact distribution.
        what: String,
        /// Indices of incidence and azimuth in the merged table.
        direction: (usize, usize),
    },
    /// Ranges of seeds that do not follow one another.
    #[error(
        "table {index} has seed {found}, but the next seed after those of the other tables is \
        {expected}; bake it with --seed {expected}"
    )]
    Seed {
        /// Index of the table.
        index: usize,
        /// Seed that continues the range.
        expected: u64,
        /// Seed of the table.
        found: u64,
    },
    /// Direction that is missing from the grid of all incidences and azimuths.
    #[error(
        "no table holds incidence {incidence_deg} deg, azimuth {azimuth_deg} deg of seed {seed}, \
        but the merged table needs it; bake this direction too"
    )]
    Gap {
        /// Incidence, degrees.
        incidence_deg: f64,
        /// Azimuth, degrees.
        azimuth_deg: f64,
        /// First seed of the tables that lack the direction.
        seed: u64,
    },
    /// Directions of one seed that hold different samples.
    #[error(
        "the tables of seed {seed} hold {found} at incidence {incidence_deg} deg, azimuth \
        {azimuth_deg} deg, but {expected} at the first direction; give the same shards for every \
        direction"
    )]
    Uneven {
        /// The seed.
        seed: u64,
        /// Incidence, degrees.
        incidence_deg: f64,
        /// Azimuth, degrees.
        azimuth_deg: f64,
        /// Shards at the first direction.
        expected: String,
        /// Shards at this direction.
        found: String,
    },
    /// Rays of a further seed while shards of one seed are missing.
    #[error(
        "shards {missing} of {} of seed {seed} are missing; merge all shards of this seed before \
        you add another seed",
        shards.of
    )]
    Incomplete {
        /// The seed.
        seed: u64,
        /// Shards that the tables hold.
        shards: Shards,
        /// Numbers of the missing shards.
        missing: String,
    },
}
