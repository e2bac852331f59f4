//! Convex parts that a beam is cut into.

use glam::DVec2;

use crate::geometry::{HalfPlane, Polygon, polygon};

/// Sum of the areas.
pub(crate) fn total_area(parts: &[Polygon]) -> f64 {
    parts.iter().map(|part| polygon::area(part)).sum()
}

/// A convex polygon less some of its parts, as convex parts of more than `least` area.
pub(crate) fn without(polygon: &Polygon, taken: &[(usize, Polygon)], least: f64) -> Vec<Polygon> {
    let mut left = vec![polygon.clone()];
    for (_, taken) in taken {
        let planes: Vec<HalfPlane> = polygon::edges(taken).collect();
        left = left
            .into_iter()
            .flat_map(|part| polygon::subtract(&part, &planes, least).unwrap_or(vec![part]))
            .collect();
    }
    left.retain(|part| polygon::area(part) > least);
    left
}

/// The box of all.
pub(crate) fn bounds_of_all(parts: &[Polygon]) -> (DVec2, DVec2) {
    let start = polygon::bounds(&[]);
    parts
        .iter()
        .map(|part| polygon::bounds(part))
        .fold(start, |a, b| (a.0.min(b.0), a.1.max(b.1)))
}
