//! Numbers of facets at which one way to bake replaces another, and the error of an exact mean.

/// Least number of facets from which the hierarchy is faster than a loop over all facets, and a
/// cell is worth taking apart.
///
/// Measured ray by ray, in million rays/s on 1 thread, loop against hierarchy:
/// 6 facets 5.0 against 2.9, 24 facets 2.0 against 2.6, 54 facets 1.0 against 2.0.
pub(crate) const SMALL: usize = 24;

/// Largest number of facets of a body that rays cross as a program, many rays side by side.
pub(crate) const PROGRAM_FACETS: usize = 16;

/// Largest number of planar facets that the exact method takes, after joining coplanar triangles.
///
/// They are the facets of a cell, or of one body of each kind if the cell is taken apart.
pub(crate) const MOST_FACETS: usize = 6144;

/// Largest number of planar facets of one body that the exact method takes. The work grows with
/// their square.
pub(crate) const MOST_FACETS_OF_BODY: usize = 2048;

/// Largest number of triangles of a cell that is not taken apart. Joining those of a plane takes a
/// time that grows with their square.
pub(crate) const MOST_TRIANGLES: usize = 1 << 14;

/// Largest error of an exact mean over azimuths: the L1 norm of eta x histogram together with the
/// shares of the fates.
pub(crate) const MEAN_ERROR: f64 = 1e-4;
