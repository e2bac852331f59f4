//! Why tables cannot be merged. Indices are positions in the list given.

use crate::table::shards::Shards;

/// Why tables cannot be merged.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Mismatch {
    /// Nothing to merge.
    #[error("no table to merge; name at least one")]
    Empty,
    /// A field that says what was baked is not the same.
    #[error(
        "{field} of table {index} is {found}, that of the first is {expected}; merge tables of \
        one design and method only"
    )]
    Field {
        /// Name of the field, as in the file.
        field: &'static str,
        /// Which table.
        index: usize,
        /// Value in the first table.
        expected: String,
        /// Value in this one.
        found: String,
    },
    /// Both tables hold the same rays.
    #[error(
        "tables {first} and {second} both hold {what} at direction {direction:?}, which would be \
        counted twice; leave \
         one of them out, or bake it with another --seed"
    )]
    Overlap {
        /// One table.
        first: usize,
        /// The other.
        second: usize,
        /// What both hold: rays of a seed, a shard, the exact distribution.
        what: String,
        /// Index along incidence and azimuth of the merged table.
        direction: (usize, usize),
    },
    /// The ranges of seeds do not follow one another.
    #[error(
        "table {index} has seed {found}, expected {expected}, the one after the seeds of the \
        other tables; bake it \
         with --seed {expected}"
    )]
    Seed {
        /// Which table.
        index: usize,
        /// The seed that would continue the range.
        expected: u64,
        /// The seed of the table.
        found: u64,
    },
    /// The directions of the tables together are no grid.
    #[error(
        "no table holds incidence {incidence_deg} deg, azimuth {azimuth_deg} deg of seed {seed}, \
        which the directions \
         of the others ask for; bake it too"
    )]
    Gap {
        /// Incidence, degrees.
        incidence_deg: f64,
        /// Azimuth, degrees.
        azimuth_deg: f64,
        /// First seed of the tables that lack it.
        seed: u64,
    },
    /// Directions of one seed that hold different samples.
    #[error(
        "the tables of seed {seed} hold {found} at incidence {incidence_deg} deg, azimuth \
        {azimuth_deg} deg, and \
         {expected} at the first direction; merge the shards of every direction alike"
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
        /// Shards there.
        found: String,
    },
    /// Some shards of one seed, and rays of another.
    #[error(
        "shards {missing} of {} of seed {seed} are missing; merge all of one seed before rays of \
        another are added",
        shards.of
    )]
    Incomplete {
        /// The seed.
        seed: u64,
        /// What there is.
        shards: Shards,
        /// Numbers of those that are not there.
        missing: String,
    },
}
