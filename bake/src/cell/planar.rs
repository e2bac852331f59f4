//! A cell as the exact method takes it: the planar facets and the openings of its bodies, or why it
//! does not.

use crate::cell::body::Body;
use crate::cell::limits::{MEAN_ERROR, MOST_FACETS};
use crate::cell::part::Part;

/// Why a cell cannot be baked exactly.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExactError {
    /// An average over azimuths is an integral that no finite set of polygons gives.
    #[error("the exact mean over azimuths is a quadrature, within {MEAN_ERROR}")]
    MeanAzimuth,
    /// A mean has no paths to say where their light goes.
    #[error(
        "the cell sends light off straight back, and an exact mean over azimuths would not say \
        where; rays do (or leave it out: \
         --deviations off)"
    )]
    MeanDeviates,
    /// Facets that are no mirrors of one normal each.
    #[error("{option} leaves no plane mirrors, which the exact method needs")]
    NoPlanes {
        /// The option that asks for others.
        option: String,
    },
    /// Joining triangles to planes would take minutes.
    #[error(
        "the cell has {triangles} triangles in one piece and the exact method takes at most \
        {limit}; give --method rays"
    )]
    TooFine {
        /// Triangles.
        triangles: usize,
        /// The limit.
        limit: usize,
    },
    /// The work grows faster than the number of facets.
    #[error(
        "the cell has {facets} planar facets and the exact method takes at most {limit}; give \
        --method rays"
    )]
    TooManyFacets {
        /// Facets after joining coplanar triangles.
        facets: usize,
        /// The limit.
        limit: usize,
    },
}

/// A cell prepared for exact baking: of a sheet of many cells one body of each kind.
#[derive(Debug, Clone)]
pub(crate) struct ExactCell {
    /// Its bodies.
    pub bodies: Vec<Body>,
    /// Of all bodies, each by its weight, square edge lengths.
    pub entrance_area: f64,
}

impl ExactCell {
    /// Finds the openings of the parts of a cell and checks the number of their facets.
    ///
    /// # Errors
    /// [`ExactError::TooManyFacets`].
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
        let facets = exact.facet_count();
        if facets > MOST_FACETS {
            return Err(ExactError::TooManyFacets {
                facets,
                limit: MOST_FACETS,
            });
        }
        Ok(exact)
    }

    /// Area of the entrance, square edge lengths; of a sheet of many cells as
    /// [`tables::Exact::entrance_area`] says.
    pub(crate) fn entrance_area(&self) -> f64 {
        self.entrance_area
    }

    /// Number of planar facets after joining coplanar triangles, in one body of each kind.
    pub(crate) fn facet_count(&self) -> usize {
        self.bodies.iter().map(|body| body.facets.len()).sum()
    }
}
