//! Convex polygons of the plane: area, clipping, splitting, subtraction, hull.
//!
//! A polygon is a list of corners, counter-clockwise, in any unit of length. Both sides of a cut
//! share its new corners. So the parts of a polygon cover it without gap or overlap, and their
//! areas sum to its area within rounding.
//!
//! A corner counts as on a cutting line if it is closer to the line than the rounding error of its
//! distance. Without this rule, cuts along shared edges would leave meaningless slivers.

use glam::DVec2;
use tables::polygon::{Intersection, walk};

/// The corners of a convex polygon, counter-clockwise. An empty list means that nothing is left.
pub(crate) type Polygon = Vec<DVec2>;

/// A half-plane: the points where an affine function is not positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HalfPlane {
    /// Gradient of the function, of any length.
    pub gradient: DVec2,
    /// Point where the function takes the value `constant`.
    pub anchor: DVec2,
    /// Value at `anchor`.
    pub constant: f64,
}

impl HalfPlane {
    /// Returns the half-plane to the left of the directed line from `a` to `b`. It is the inside of
    /// an edge of a counter-clockwise polygon.
    pub(crate) fn left_of(a: DVec2, b: DVec2) -> Self {
        let edge = b - a;
        HalfPlane {
            gradient: DVec2::new(edge.y, -edge.x),
            anchor: a,
            constant: 0.0,
        }
    }

    /// Evaluates the affine function at `p`. The result is 0 if rounding could have changed its
    /// sign.
    pub(crate) fn value(&self, p: DVec2) -> f64 {
        let offset = p - self.anchor;
        let value = self.gradient.dot(offset) + self.constant;
        // The products and sums are rounded three times and each coordinate once: 4 ulp of the
        // sizes of the terms bound the error.
        let size = self.gradient.abs().dot(p.abs() + self.anchor.abs()) + self.constant.abs();
        if value.abs() <= 4.0 * f64::EPSILON * size {
            0.0
        } else {
            value
        }
    }

    /// Returns the complement.
    #[cfg(test)]
    pub(crate) fn flipped(&self) -> Self {
        HalfPlane {
            gradient: -self.gradient,
            anchor: self.anchor,
            constant: -self.constant,
        }
    }
}

/// Returns the signed area: positive for counter-clockwise corners, 0 for fewer than three.
pub(crate) fn area(polygon: &[DVec2]) -> f64 {
    let Some(&first) = polygon.first() else {
        return 0.0;
    };
    // Offsets from a corner are used: far from the origin the plain shoelace formula would cancel.
    let twice: f64 = polygon
        .windows(2)
        .map(|w| (w[0] - first).perp_dot(w[1] - first))
        .sum();
    0.5 * twice
}

/// Returns the smallest and the largest coordinates; (+inf, -inf) for no points.
pub(crate) fn bounds(polygon: &[DVec2]) -> (DVec2, DVec2) {
    let start = (DVec2::splat(f64::INFINITY), DVec2::splat(f64::NEG_INFINITY));
    polygon
        .iter()
        .fold(start, |(low, high), &p| (low.min(p), high.max(p)))
}

/// Returns the half-planes of the edges, whose intersection is the polygon. Edges of length 0 are
/// left out.
pub(crate) fn edges(polygon: &[DVec2]) -> impl Iterator<Item = HalfPlane> + '_ {
    edges_longer_than(0.0, polygon)
}

/// Returns the half-planes of the edges that are longer than `length`.
pub(crate) fn edges_longer_than(
    length: f64,
    polygon: &[DVec2],
) -> impl Iterator<Item = HalfPlane> + '_ {
    (0..polygon.len()).filter_map(move |i| {
        let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        (a.distance(b) > length).then(|| HalfPlane::left_of(a, b))
    })
}

/// Cuts a convex polygon into the part inside and the part outside a half-plane. A part without
/// extent is empty.
pub(crate) fn split(polygon: &[DVec2], plane: &HalfPlane) -> (Polygon, Polygon) {
    let (mut inside, mut outside) = (Polygon::new(), Polygon::new());
    cut(polygon, plane, &mut inside, Some(&mut outside));
    (inside, outside)
}

/// Writes the part of `polygon` inside the half-plane to `inside`, and the rest to `outside` if
/// given.
fn cut(
    polygon: &[DVec2],
    plane: &HalfPlane,
    inside: &mut Polygon,
    mut outside: Option<&mut Polygon>,
) {
    inside.clear();
    if let Some(out) = outside.as_deref_mut() {
        out.clear();
    }
    let (mut some_inside, mut some_outside) = (false, false);
    walk(
        polygon,
        |p| plane.value(p),
        |met| match met {
            Intersection::Crossing([before, here]) => {
                // The crossing is computed from the inside corner outwards, so that both neighbours
                // of an edge get the same bits.
                let ((from, at), (to, far)) = if here.1 < 0.0 {
                    (here, before)
                } else {
                    (before, here)
                };
                let crossing = from + (to - from) * (at / (at - far));
                inside.push(crossing);
                if let Some(out) = outside.as_deref_mut() {
                    out.push(crossing);
                }
            }
            Intersection::Corner(corner, value) => {
                if value <= 0.0 {
                    inside.push(corner);
                }
                if value >= 0.0
                    && let Some(out) = outside.as_deref_mut()
                {
                    out.push(corner);
                }
                some_inside |= value < 0.0;
                some_outside |= value > 0.0;
            }
        },
    );
    if !some_inside {
        inside.clear();
    }
    if !some_outside && let Some(out) = outside {
        out.clear();
    }
}

/// Returns the part of a convex polygon inside every half-plane, empty if nothing is left.
pub(crate) fn clip(polygon: &[DVec2], planes: impl IntoIterator<Item = HalfPlane>) -> Polygon {
    let mut kept = polygon.to_vec();
    let mut scratch = Polygon::with_capacity(polygon.len() + 4);
    for plane in planes {
        cut(&kept, &plane, &mut scratch, None);
        std::mem::swap(&mut kept, &mut scratch);
        if kept.is_empty() {
            break;
        }
    }
    kept
}

/// Returns a convex polygon less the intersection of half-planes, as convex parts.
///
/// Returns `None` if no more than the area `least` would be cut off, so that an untouched polygon
/// stays in one piece.
pub(crate) fn subtract(
    polygon: &[DVec2],
    planes: &[HalfPlane],
    least: f64,
) -> Option<Vec<Polygon>> {
    if area(&clip(polygon, planes.iter().copied())) <= least {
        return None;
    }
    let mut parts = Vec::new();
    let mut rest = polygon.to_vec();
    for plane in planes {
        let (inside, outside) = split(&rest, plane);
        if !outside.is_empty() {
            parts.push(outside);
        }
        rest = inside;
    }
    Some(parts)
}

/// Returns the convex hull, counter-clockwise.
///
/// Corners within `slack` (the unit of the points) of the line between their neighbours are left
/// out.
pub(crate) fn hull(points: &[DVec2], slack: f64) -> Polygon {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    let chain = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain = Polygon::new();
        for p in points {
            while let [.., a, b] = chain[..] {
                if (b - a).perp_dot(p - a) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut sorted.iter().copied());
    hull.extend(chain(&mut sorted.iter().rev().copied()));
    let idle = |a: DVec2, b: DVec2, c: DVec2| {
        let twin = a.distance(b) <= slack;
        let between = (b - a).dot(c - b) >= 0.0 && (b - a).perp_dot(c - a) <= slack * a.distance(c);
        twin || between
    };
    let mut i = 0;
    while i < hull.len() && hull.len() > 2 {
        let n = hull.len();
        if idle(hull[(i + n - 1) % n], hull[i], hull[(i + 1) % n]) {
            hull.remove(i);
            // The corner before this one has a new neighbour.
            i = i.saturating_sub(1);
        } else {
            i += 1;
        }
    }
    if hull.len() < 3 { Polygon::new() } else { hull }
}

/// Returns whether the polygon turns left, or goes straight on, at every corner.
pub(crate) fn is_convex(polygon: &[DVec2]) -> bool {
    let n = polygon.len();
    (0..n).all(|i| {
        let (a, b, c) = (polygon[i], polygon[(i + 1) % n], polygon[(i + 2) % n]);
        let (first, second) = (b - a, c - b);
        first.perp_dot(second) >= -1e-14 * first.length() * second.length()
    })
}

/// Cuts a simple counter-clockwise polygon into convex parts: itself if it is convex, otherwise
/// triangles, by ear clipping.
pub(crate) fn convex_parts(polygon: &[DVec2]) -> Vec<Polygon> {
    if is_convex(polygon) {
        return vec![polygon.to_vec()];
    }
    let mut rest = polygon.to_vec();
    let mut parts = Vec::new();
    while rest.len() > 3 {
        let n = rest.len();
        let ear = (0..n).find(|&i| {
            let triangle = [rest[(i + n - 1) % n], rest[i], rest[(i + 1) % n]];
            area(&triangle) > 0.0
                && !rest
                    .iter()
                    .any(|p| !triangle.contains(p) && holds(&triangle, *p))
        });
        // A simple polygon always has an ear. One that crosses itself loses a corner here, so that
        // the loop ends.
        let i = ear.unwrap_or(0);
        let triangle = vec![rest[(i + n - 1) % n], rest[i], rest[(i + 1) % n]];
        if area(&triangle) > 0.0 {
            parts.push(triangle);
        }
        rest.remove(i);
    }
    parts.push(rest);
    parts
}

fn holds(polygon: &[DVec2], p: DVec2) -> bool {
    edges(polygon).all(|edge| edge.value(p) <= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn square(low: f64, high: f64) -> Polygon {
        vec![
            DVec2::new(low, low),
            DVec2::new(high, low),
            DVec2::new(high, high),
            DVec2::new(low, high),
        ]
    }

    #[test]
    fn clipping_two_squares_leaves_their_overlap() {
        let overlap = clip(&square(0.0, 2.0), edges(&square(1.0, 3.0)));
        assert_eq!(area(&overlap), 1.0);
        assert_eq!(bounds(&overlap), (DVec2::splat(1.0), DVec2::splat(2.0)));
        assert!(
            clip(&square(0.0, 1.0), edges(&square(1.0, 2.0))).is_empty(),
            "a shared corner is no overlap"
        );
    }

    #[test]
    fn a_hole_leaves_a_ring_of_convex_parts() {
        let planes: Vec<_> = edges(&square(1.0, 2.0)).collect();
        let ring = subtract(&square(0.0, 3.0), &planes, 0.0).expect("they overlap");
        assert_eq!(ring.len(), 4);
        assert!(ring.iter().all(|part| is_convex(part)));
        assert_eq!(ring.iter().map(|part| area(part)).sum::<f64>(), 8.0);
        assert_eq!(
            subtract(&square(5.0, 6.0), &planes, 0.0),
            None,
            "an untouched polygon stays whole"
        );
    }

    #[test]
    fn an_l_shape_falls_into_convex_parts_of_its_area() {
        let l = [(0., 0.), (2., 0.), (2., 1.), (1., 1.), (1., 2.), (0., 2.)]
            .map(|(x, y)| DVec2::new(x, y));
        let parts = convex_parts(&l);
        assert!(parts.len() > 1 && parts.iter().all(|part| is_convex(part)));
        assert!((parts.iter().map(|part| area(part)).sum::<f64>() - 3.0).abs() < 1e-15);
    }

    #[test]
    fn the_hull_drops_corners_on_its_edges() {
        let mut points = square(0.0, 1.0);
        points.extend([
            DVec2::new(0.5, 0.0),
            DVec2::new(0.5, 0.5),
            DVec2::new(1.0, 0.3),
        ]);
        assert_eq!(hull(&points, 1e-15), square(0.0, 1.0));
        assert!(hull(&points[..2], 0.0).is_empty());
    }

    proptest! {
        // Each part is computed from corners good to 1 ulp of the coordinates, which are below 4
        // here. The errors of the areas stay below corners x extent x ulp = 16 x 4 x 4.4e-16 =
        // 3e-14.
        #[test]
        fn parts_sum_to_the_whole(
            angles in proptest::collection::vec(0.0..std::f64::consts::TAU, 3..12),
            ax in -2.0..2.0_f64, ay in -2.0..2.0_f64, bx in -2.0..2.0_f64, by in -2.0..2.0_f64,
        ) {
            let points: Vec<DVec2> = angles.iter().map(|&t| 2.0 * DVec2::from_angle(t)).collect();
            let polygon = hull(&points, 0.0);
            let (a, b) = (DVec2::new(ax, ay), DVec2::new(bx, by));
            let (inside, outside) = split(&polygon, &HalfPlane::left_of(a, b));
            prop_assert!((area(&inside) + area(&outside) - area(&polygon)).abs() < 3e-14);
            prop_assert!(area(&inside) > -3e-14 && area(&outside) > -3e-14);
            let (outside_too, inside_too) = split(&polygon, &HalfPlane::left_of(a, b).flipped());
            prop_assert!((area(&inside) - area(&inside_too)).abs() < 3e-14);
            prop_assert!((area(&outside) - area(&outside_too)).abs() < 3e-14);
        }
    }
}
