//! A cell in the form that the exact method takes, or why the method does not take it.
//!
//! The form is the planar facets and the openings of the bodies of the cell.

use crate::cell::body::Body;
use crate::cell::body::Part;
use crate::cell::prepared::{MOST_FACETS, MOST_FACETS_OF_BODY};

/// What an option does that the exact method cannot bake, behind its name.
pub(crate) const NO_PLANES: &str = "leaves no plane mirrors, which the exact method needs";

/// A cell prepared for the exact bake. Of a sheet of many cells it holds one body of each kind.
#[derive(Debug, Clone)]
pub(crate) struct ExactCell {
    /// Bodies of the cell, one of each kind.
    pub bodies: Vec<Body>,
    /// Area of the entrances of all bodies, each times its weight, square edge lengths.
    pub entrance_area: f64,
}

impl ExactCell {
    /// Finds the openings of the parts of a cell and checks the number of their facets.
    ///
    /// # Errors
    /// Says so if there are more than [`MOST_FACETS`] planar facets, or more than
    /// [`MOST_FACETS_OF_BODY`] in one body.
    pub(crate) fn new(parts: &[Part]) -> Result<Self, String> {
        let most = parts.iter().map(|part| part.copies).max();
        let weight = |copies: usize| copies as f64 / most.unwrap_or(1) as f64;
        let bodies: Vec<Body> = parts
            .iter()
            .map(|part| Body::new(part, weight(part.copies)))
            .collect();
        let exact = ExactCell {
            entrance_area: bodies
                .iter()
                .map(|body| body.weight * body.entrance_area)
                .sum(),
            bodies,
        };
        let largest = exact.bodies.iter().map(|body| body.facets.len()).max();
        let counts = [
            (largest.unwrap_or(0), MOST_FACETS_OF_BODY),
            (exact.facet_count(), MOST_FACETS),
        ];
        match counts.into_iter().find(|(facets, limit)| facets > limit) {
            Some((facets, limit)) => Err(format!(
                "the cell has {facets} planar facets and the exact method takes at most {limit}; \
                give --method rays"
            )),
            None => Ok(exact),
        }
    }

    /// Returns the area of the entrance, square edge lengths. For a sheet of many cells it is that
    /// of [`tables::Exact::entrance_area`].
    pub(crate) fn entrance_area(&self) -> f64 {
        self.entrance_area
    }

    /// Returns the number of planar facets in one body of each kind, after joining coplanar
    /// triangles.
    pub(crate) fn facet_count(&self) -> usize {
        self.bodies.iter().map(|body| body.facets.len()).sum()
    }
}
