//! What became of the light of one direction.

use tables::{Fate, Path};

/// What became of the light of one direction.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Share {
    /// Retroreflecting polygons and maps, incidence frame, edge lengths.
    pub paths: Vec<Path>,
    /// Share of the launched light by fate, in the order of [`Fate::ALL`].
    pub fate: [f64; Fate::ALL.len()],
    /// Retroreflected fraction: `retroreflected` and `out_of_range` together.
    pub eta: f64,
    /// Probability per launched ray of each bin, `[v][u]` row-major: sums to the share of
    /// `retroreflected`.
    pub histogram: Vec<f64>,
    /// Net share of the slivers given up as rounding: the shares of all fates sum to 1 less this.
    pub dropped: f64,
}
