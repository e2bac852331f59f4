//! The fates and ray shifts of the light of one direction.

use tables::{Fate, Path};

/// The fates and ray shifts of the light of one direction.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Share {
    /// Polygons of retroreflected light with their maps, incidence frame, edge lengths.
    pub paths: Vec<Path>,
    /// Share of the launched light by fate, in the order of [`Fate::ALL`].
    pub fate: [f64; Fate::ALL.len()],
    /// Retroreflected share eta: the sum of the fates `retroreflected` and `out_of_range`.
    pub retroreflected: f64,
    /// Probability per launched ray of each bin, `[v][u]`, row-major. Its sum is the share of the
    /// fate `retroreflected`.
    pub histogram: Vec<f64>,
    /// Net share of the slivers that were given up as rounding. The shares of all fates sum to 1
    /// less this.
    pub dropped: f64,
}
