//! Area and centroid of polygons, and the cutting of convex ones along a line.
//!
//! The cutting is that of Sutherland and Hodgman 1974. Points are of any type: `bake` has vectors,
//! tables have pairs of numbers. The caller says how a point on an edge is made, so that neighbours
//! who share the edge get equal bits.

/// Returns the signed area of a polygon, positive when it is counter-clockwise.
///
/// It is computed relative to the first corner, so a polygon far from the origin loses no digits.
pub fn area(corners: &[[f64; 2]]) -> f64 {
    0.5 * fan(corners).map(|(_, _, twice)| twice).sum::<f64>()
}

/// Returns the centroid of a polygon, or its first corner if the area is 0.
pub(crate) fn centroid(corners: &[[f64; 2]]) -> [f64; 2] {
    let Some(&[x, y]) = corners.first() else {
        return [0.0; 2];
    };
    let total: f64 = fan(corners).map(|(_, _, twice)| twice).sum();
    if total == 0.0 {
        return [x, y];
    }
    let sum = |axis: usize| {
        fan(corners)
            .map(|(a, b, twice)| twice * (a[axis] + b[axis]))
            .sum::<f64>()
            / (3.0 * total)
    };
    [x + sum(0), y + sum(1)]
}

/// Returns the triangles from the first corner: two sides as vectors, and twice the signed area.
pub(crate) fn fan(corners: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2], f64)> + '_ {
    let origin = corners.first().copied().unwrap_or_default();
    let side = move |corner: &[f64; 2]| [corner[0] - origin[0], corner[1] - origin[1]];
    corners.windows(2).map(move |pair| {
        let (a, b) = (side(&pair[0]), side(&pair[1]));
        (a, b, a[0] * b[1] - a[1] * b[0])
    })
}

/// Event of a walk around a polygon that a line cuts: points with their value, which is 0 on the
/// line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Intersection<P> {
    /// Corner with its value.
    Corner(P, f64),
    /// Edge across the line, from a corner to the next; neither of them is on the line.
    Crossing([(P, f64); 2]),
}

/// Walks once around a convex polygon and calls `meet` at every corner and crossing.
///
/// The walk begins with the edge from the last corner to the first. `value` is negative on one side
/// of the line and positive on the other.
#[inline]
pub fn walk<P: Copy>(
    corners: &[P],
    value: impl Fn(P) -> f64,
    mut meet: impl FnMut(Intersection<P>),
) {
    let Some(&last) = corners.last() else { return };
    let mut before = (last, value(last));
    for &corner in corners {
        let here = (corner, value(corner));
        if here.1 * before.1 < 0.0 {
            meet(Intersection::Crossing([before, here]));
        }
        meet(Intersection::Corner(here.0, here.1));
        before = here;
    }
}

/// Returns the part of a convex polygon where `value` is not positive, its corners in their order.
///
/// `on` makes the point at a given part of the way from one corner to the next.
pub fn clip<P: Copy>(
    corners: &[P],
    value: impl Fn(P) -> f64,
    on: impl Fn(P, P, f64) -> P,
) -> Vec<P> {
    let mut kept = Vec::with_capacity(corners.len() + 1);
    let mut seen = 0;
    let mut closing = None;
    walk(corners, value, |met| match met {
        Intersection::Crossing([(p, a), (q, b)]) => {
            let point = on(p, q, a / (a - b));
            // The edge from the last corner to the first comes at the end.
            if seen == 0 {
                closing = Some(point);
            } else {
                kept.push(point);
            }
        }
        Intersection::Corner(p, value) => {
            seen += 1;
            if value <= 0.0 {
                kept.push(p);
            }
        }
    });
    kept.extend(closing);
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cuts a unit square by half planes, and checks the number of corners left and the area.
    #[test]
    fn a_square_is_cut() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let on = |p: [f64; 2], q: [f64; 2], part: f64| [0, 1].map(|k| p[k] + part * (q[k] - p[k]));
        let cut = |normal: [f64; 2], offset: f64| {
            let value = move |p: [f64; 2]| normal[0] * p[0] + normal[1] * p[1] - offset;
            clip(&square, value, on)
        };
        let cases = [
            ([1.0, 0.0], 0.25, 4, 0.25),
            ([-1.0, 0.0], -0.25, 4, 0.75),
            ([1.0, 1.0], 0.5, 3, 0.125),
            ([1.0, 1.0], 1.0, 3, 0.5),
            ([1.0, 0.0], 2.0, 4, 1.0),
            ([1.0, 0.0], -2.0, 0, 0.0),
            ([1.0, 0.0], 1.0, 4, 1.0),
        ];
        for (normal, offset, corners, expected) in cases {
            let kept = cut(normal, offset);
            assert_eq!((kept.len(), area(&kept)), (corners, expected), "{normal:?}");
        }
        // The first corner that is kept stays the first.
        assert_eq!(cut([0.0, 1.0], 0.5)[0], square[0]);
    }
}
