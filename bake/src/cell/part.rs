//! Planar facets that light meets: one body of each kind, or the cell as a whole.
//!
//! Triangles of one plane are joined.

use crate::cell::bodies::Kind;
use crate::cell::planes;
use crate::cell::planes::PlanarFacet;
use meshes::{Cell, Entrance};

/// Planar facets under one entrance.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Part {
    /// Planar facets, with coplanar neighbours joined.
    pub facets: Vec<PlanarFacet>,
    /// The entrance that light enters by.
    pub entrance: Entrance,
    /// Number of copies of the part in the cell.
    pub copies: usize,
}

impl Part {
    /// Joins the facets of one body of `kind`.
    pub(crate) fn of(kind: &Kind) -> Self {
        Part {
            facets: planes::join(&kind.facets),
            entrance: kind.entrance.clone(),
            copies: kind.places.len(),
        }
    }

    /// Joins the facets of the whole cell.
    pub(crate) fn whole(cell: &Cell) -> Self {
        Part {
            facets: planes::join(&cell.facets),
            entrance: cell.entrance.clone(),
            copies: 1,
        }
    }
}
