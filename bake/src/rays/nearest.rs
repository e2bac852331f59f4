//! The nearest facet along a ray, whoever looks for it and in whatever order.

use crate::optics::{Ray, Triangle};

/// The nearest facet so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nearest {
    /// Index of the facet, where there is one.
    pub facet: Option<usize>,
    /// Its distance, or the limit of the search, edge lengths.
    pub distance: f64,
    /// Whether it is met from the front.
    pub front: bool,
}

impl Nearest {
    /// Nothing yet; only facets up to `limit` edge lengths away count.
    pub(crate) fn within(limit: f64) -> Self {
        Nearest {
            facet: None,
            distance: limit,
            front: false,
        }
    }

    /// Takes `facet` if `ray` meets it nearer than what is known. Ties go to the lower index, so
    /// the answer does not depend on the order of the offers.
    #[inline]
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
