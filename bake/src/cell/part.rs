//! What light meets of a cell, its triangles joined to planar facets: one body of each kind, or the
//! cell as it is.

use crate::cell::bodies::Kind;
use crate::cell::planes;
use crate::cell::planes::Facet;
use meshes::{Cell, Entrance};

/// The planar facets under one entrance.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Part {
    /// Facets, coplanar neighbours joined.
    pub facets: Vec<Facet>,
    /// Where light enters.
    pub entrance: Entrance,
    /// How often it occurs in the cell.
    pub copies: usize,
}

impl Part {
    /// One body of a kind.
    pub(crate) fn of(kind: &Kind) -> Self {
        Part {
            facets: planes::join(&kind.facets),
            entrance: kind.entrance.clone(),
            copies: kind.places.len(),
        }
    }

    /// The cell as it is.
    pub(crate) fn whole(cell: &Cell) -> Self {
        Part {
            facets: planes::join(&cell.facets),
            entrance: cell.entrance.clone(),
            copies: 1,
        }
    }
}
