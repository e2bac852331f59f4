//! Convex parts into which a beam is cut.

use glam::DVec2;

use crate::geometry::{HalfPlane, Polygon, polygon};

/// Length of an edge, edge lengths, below which its direction is rounding. Such an edge would cut a
/// polygon anywhere. Without it a thin polygon is longer by no more than this area.
const SHORT: f64 = 1e-15;

/// Distance, edge lengths, by which a polygon may cross the line of its own edge. The rounding of a
/// long edge is less.
const STRAIGHT: f64 = 1e-13;

/// Returns the sum of the areas of `parts`.
pub(crate) fn total_area(parts: &[Polygon]) -> f64 {
    parts.iter().map(|part| polygon::area(part)).sum()
}

/// Returns `polygon` less the convex parts `taken`, as convex parts of more than `least` area each.
pub(crate) fn without(polygon: &Polygon, taken: &[(usize, Polygon)], least: f64) -> Vec<Polygon> {
    let mut left = vec![polygon.clone()];
    for (_, taken) in taken {
        let edges = polygon::edges_longer_than(SHORT, taken);
        let planes: Vec<HalfPlane> = edges.map(|edge| beside(edge, taken)).collect();
        left = left
            .into_iter()
            .flat_map(|part| polygon::subtract(&part, &planes, least).unwrap_or(vec![part]))
            .collect();
    }
    left.retain(|part| polygon::area(part) > least);
    left
}

/// Returns the half-plane moved outward until `polygon` lies in it.
///
/// The direction of a short edge is off by rounding over its length. Its line would cut off a part
/// of its own polygon.
fn beside(edge: HalfPlane, polygon: &Polygon) -> HalfPlane {
    let beyond = polygon.iter().map(|&p| edge.value(p)).fold(0.0, f64::max);
    if beyond <= STRAIGHT * edge.gradient.length() {
        return edge;
    }
    HalfPlane {
        constant: edge.constant - beyond,
        ..edge
    }
}

/// Returns the lowest and the highest coordinates of all `parts` together.
pub(crate) fn bounds_of_all(parts: &[Polygon]) -> (DVec2, DVec2) {
    let start = polygon::bounds(&[]);
    parts
        .iter()
        .map(|part| polygon::bounds(part))
        .fold(start, |a, b| (a.0.min(b.0), a.1.max(b.1)))
}
