//! Numbers of facets at which one way to bake takes the place of another, and the error of an exact
//! mean.

/// From this number of facets on, the hierarchy is faster than a loop over all, and a cell is worth
/// taking apart. Ray by ray, measured by `tests/speed.rs`, million rays/s on 1 thread: 6 facets 2.9
/// against 5.0, 24 facets 2.6 against 2.0, 54 facets 2.0 against 1.0.
pub(crate) const SMALL: usize = 24;

/// Facets at most of a body that rays cross as a program, many side by side.
pub(crate) const PROGRAM_FACETS: usize = 16;

/// Most facets, after joining coplanar triangles, that the exact method takes of a cell, or of one
/// body of each kind where the cell is taken apart: the work grows with their square.
pub(crate) const MOST_FACETS: usize = 2048;

/// Most triangles of a cell that is not taken apart: those of a plane are joined in a time that
/// grows with their square.
pub(crate) const MOST_TRIANGLES: usize = 1 << 14;

/// Most that an exact mean over azimuths is off: L1 of eta x histogram together with the shares of
/// the fates.
pub(crate) const MEAN_ERROR: f64 = 1e-4;
