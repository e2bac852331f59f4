//! Planar facets of a cell, or of one of the bodies that it falls into, prepared for the exact bake.

use crate::cell::bodies::Kind;
use crate::cell::planes::PlanarFacet;
use crate::cell::{planes, rim};
use crate::geometry::{Polygon, polygon};
use glam::DVec2;
use meshes::{Cell, Entrance};

/// Largest share of a period that facets may leave open without showing their backs. Through a
/// wider gap light comes through and meets the backs.
const OPEN: f64 = 1e-9;

/// Planar facets and the openings that light enters by.
#[derive(Debug, Clone)]
pub(crate) struct Body {
    /// Planar facets. For a lattice with gaps they include the backs.
    pub facets: Vec<PlanarFacet>,
    /// Lattice vectors, edge lengths. They are `None` without a lattice and for a lattice of
    /// recesses, which do not see each other.
    pub lattice: Option<[DVec2; 2]>,
    /// Convex parts of the openings.
    pub openings: Vec<Polygon>,
    /// Area of the entrance, square edge lengths.
    pub entrance_area: f64,
    /// Height of the entrance plane, edge lengths.
    pub height: f64,
    /// Frequency of the body, relative to the most frequent body of the cell.
    pub weight: f64,
    /// One period of the whole sheet, for light that crosses from recess to recess; `None` if this
    /// body is that, or if there is no sheet.
    pub sheet: Option<Box<Body>>,
}

impl Body {
    /// Finds the openings of `part`; `weight` is its frequency relative to the most frequent part.
    pub(crate) fn new(part: &Part, weight: f64) -> Self {
        let entrance = &part.entrance;
        let entrance_area = polygon::area(&entrance.polygon);
        let recesses = entrance
            .lattice
            .and_then(|_| rim::openings(&part.facets, entrance.height, entrance_area));
        let sheet = recesses.as_ref().map(|_| Body::open(part, weight, None));
        Body {
            sheet: sheet.map(Box::new),
            ..Body::open(part, weight, recesses)
        }
    }

    /// Makes the body with `recesses` for openings or, without them, with all that its lattice has.
    fn open(part: &Part, weight: f64, recesses: Option<Vec<Polygon>>) -> Self {
        let (mut facets, entrance) = (part.facets.clone(), &part.entrance);
        let entrance_area = polygon::area(&entrance.polygon);
        let lattice = entrance.lattice.filter(|_| recesses.is_none());
        let covered: f64 = facets.iter().map(|facet| facet.area_from_above()).sum();
        if lattice.is_some() && covered < (1.0 - OPEN) * entrance_area {
            let backs: Vec<PlanarFacet> = facets.iter().map(PlanarFacet::back).collect();
            facets.extend(backs);
        }
        let openings = recesses.unwrap_or_else(|| vec![entrance.polygon.clone()]);
        Body {
            facets,
            lattice,
            openings: openings
                .iter()
                .flat_map(|opening| polygon::convex_parts(opening))
                .collect(),
            entrance_area,
            height: entrance.height,
            weight,
            sheet: None,
        }
    }
}

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
