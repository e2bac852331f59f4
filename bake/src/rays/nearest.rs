//! Nearest facet along a ray, independent of the order in which facets are tried.

use crate::optics::{Ray, Triangle};

/// Nearest facet found so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nearest {
    /// Index of the facet; `None` if no facet is found yet.
    pub facet: Option<usize>,
    /// Distance of the facet, or the limit of the search, edge lengths.
    pub distance: f64,
    /// True if the ray meets the facet from the front.
    pub front: bool,
}

impl Nearest {
    /// Starts a search for facets up to `limit` edge lengths away.
    pub(crate) fn within(limit: f64) -> Self {
        Nearest {
            facet: None,
            distance: limit,
            front: false,
        }
    }

    /// Takes `facet` if `ray` meets it nearer than the nearest facet so far.
    ///
    /// Of two facets at one distance the lower index wins, so the result does not depend on the
    /// order of the offers.
    #[inline(always)]
    pub(crate) fn offer(&mut self, index: usize, facet: &Triangle, ray: &Ray) {
        if let Some(contact) = facet.meet(ray) {
            let tie =
                contact.distance == self.distance && self.facet.is_none_or(|known| index < known);
            if contact.distance < self.distance || tie {
                *self = Nearest {
                    facet: Some(index),
                    distance: contact.distance,
                    front: contact.front,
                };
            }
        }
    }
}
