//! A cell in the form that the exact method takes, or why the method does not take it.
//!
//! The form is the planar facets and the openings of the bodies of the cell.

use crate::cell::body::Body;
use crate::cell::limits::{MEAN_ERROR, MOST_FACETS, MOST_FACETS_OF_BODY};
use crate::cell::part::Part;

/// The reason why a cell cannot be baked exactly.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExactError {
    /// The table is a mean over all azimuths: an integral that no finite set of polygons gives.
    #[error(
        "a mean over all azimuths is a numerical integral with an error of up to {MEAN_ERROR}, so \
        it has no exact table"
    )]
    MeanAzimuth,
    /// The table is a mean over all azimuths of a cell that sends light off the exact way back. A
    /// mean has no paths, so it could not store where the light goes.
    #[error(
        "the cell sends light off the exact way back, and an exact mean over azimuths cannot store \
        where this light goes; give --method rays, or --deviations off to leave it out"
    )]
    MeanDeviates,
    /// The facets are no plane mirrors: they do not have one normal each.
    #[error("{option} leaves no plane mirrors, which the exact method needs")]
    NoPlanes {
        /// The option that asks for such facets.
        option: String,
    },
    /// The cell has too many triangles in one piece: joining them to planes would take minutes.
    #[error(
        "the cell has {triangles} triangles in one piece and the exact method takes at most \
        {limit}; give --method rays"
    )]
    TooFine {
        /// Number of triangles.
        triangles: usize,
        /// Largest number of triangles.
        limit: usize,
    },
    /// The cell has too many planar facets: the work grows faster than their number.
    #[error(
        "the cell has {facets} planar facets and the exact method takes at most {limit}; give \
        --method rays"
    )]
    TooManyFacets {
        /// Number of facets after joining coplanar triangles.
        facets: usize,
        /// Largest number of facets.
        limit: usize,
    },
}

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
    ///
    /// Returns [`ExactError::TooManyFacets`] if there are more than [`MOST_FACETS`] planar facets, or
    /// more than [`MOST_FACETS_OF_BODY`] in one body.
    pub(crate) fn new(parts: &[Part]) -> Result<Self, ExactError> {
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
            Some((facets, limit)) => Err(ExactError::TooManyFacets { facets, limit }),
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
