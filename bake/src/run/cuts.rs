//! How far the light of two exact tables is apart, whatever polygons it is cut into.
//!
//! Two correct bakes may cut one region into different polygons: by another order of the facets, or
//! by other parts of a region that is not convex. The light is the same if each map carries the
//! same region of the entrance. So polygons are put together by their map and weight, and regions
//! are compared by area: with s = 1 for polygons of the first table and -1 for those of the second,
//! the sum of s_i s_j area(P_i and P_j) over all pairs is the integral of the squared difference of
//! the two regions. It is 0 if, and only if, they are equal.

use glam::DVec2;
use tables::Path;

use crate::geometry::{Polygon, polygon};
use crate::run::paths::{MOST_PAIRED, SAME};

/// Polygons of both tables that share a map, a weight and a deviation.
struct PathGroup<'a> {
    /// First of the paths, which stands for the map of all.
    first: &'a Path,
    pieces: Vec<SignedPolygon>,
}

/// Convex polygon of the entrance.
struct SignedPolygon {
    /// 1 for the first table, -1 for the second.
    sign: f64,
    corners: Polygon,
    low: DVec2,
    high: DVec2,
}

/// Returns the mean distance by which the outlines of the light of two directions are apart, edge
/// lengths.
///
/// It is the area of the entrance whose light the tables send differently, divided by the length of
/// all outlines: moving every corner by d changes areas by at most d times that length. Maps,
/// weights and deviations count as equal within [`SAME`]. It is infinite for more than
/// [`MOST_PAIRED`] paths, and if all outlines have length 0.
pub(crate) fn uncut(a: &[Path], b: &[Path]) -> f64 {
    if a.len().max(b.len()) > MOST_PAIRED {
        return f64::INFINITY;
    }
    let mut groups: Vec<PathGroup<'_>> = Vec::new();
    let mut outline = 0.0;
    for (paths, sign) in [(a, 1.0), (b, -1.0)] {
        for path in paths {
            let corners: Polygon = path.polygon.iter().map(|&corner| corner.into()).collect();
            outline += length(&corners);
            let pieces = polygon::convex_parts(&corners).into_iter();
            let pieces = pieces.map(|corners| SignedPolygon::new(sign, corners));
            if let Some(own) = groups.iter_mut().find(|group| same(group.first, path)) {
                own.pieces.extend(pieces);
            } else {
                groups.push(PathGroup {
                    first: path,
                    pieces: pieces.collect(),
                });
            }
        }
    }
    let area: f64 = groups.iter().map(|group| differing(&group.pieces)).sum();
    if outline > 0.0 {
        area / outline
    } else {
        f64::INFINITY
    }
}

impl SignedPolygon {
    fn new(sign: f64, corners: Polygon) -> Self {
        let (low, high) = polygon::bounds(&corners);
        SignedPolygon {
            sign,
            corners,
            low,
            high,
        }
    }

    /// Returns the area that both polygons cover.
    fn shared(&self, other: &SignedPolygon) -> f64 {
        if self.low.cmpge(other.high).any() || other.low.cmpge(self.high).any() {
            return 0.0;
        }
        polygon::area(&polygon::clip(
            &self.corners,
            polygon::edges(&other.corners),
        ))
    }
}

/// Returns whether two paths send light alike, by map, weight and deviation.
fn same(p: &Path, q: &Path) -> bool {
    let numbers = |path: &Path| {
        let [[a, b], [c, d]] = path.matrix;
        let ([e, f], [g, h]) = (path.offset, path.deviation);
        [a, b, c, d, e, f, g, h, path.weight]
    };
    let mut pairs = numbers(p).into_iter().zip(numbers(q));
    p.passes == q.passes && p.jones == q.jones && pairs.all(|(p, q)| (p - q).abs() <= SAME)
}

/// Returns the area that the polygons of one table cover and those of the other do not.
///
/// A region that one table covers n times more often than the other counts n^2 times.
fn differing(pieces: &[SignedPolygon]) -> f64 {
    let one = |(k, piece): (usize, &SignedPolygon)| {
        let own = polygon::area(&piece.corners);
        let others = pieces[..k].iter();
        let shared = others.map(|other| piece.sign * other.sign * piece.shared(other));
        own + 2.0 * shared.sum::<f64>()
    };
    // Rounding may take the sum of equal regions below 0.
    pieces.iter().enumerate().map(one).sum::<f64>().max(0.0)
}

/// Returns the length of the outline of a polygon.
fn length(corners: &[DVec2]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(&a, &b)| a.distance(b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a region in the shape of an L, which is not convex, moved right by `x`.
    fn ell(x: f64) -> Vec<[f64; 2]> {
        let corners = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]];
        corners.map(|[u, v]| [u + x, v]).to_vec()
    }

    fn path(polygon: Vec<[f64; 2]>) -> Path {
        Path {
            polygon,
            matrix: [[2.0, 0.5], [0.0, 2.0]],
            offset: [0.1, 0.2],
            weight: 0.75,
            deviation: [1e-3, 0.0],
            passes: 0,
            jones: None,
            cube: None,
        }
    }

    fn rectangle([u, v]: [f64; 2], [width, height]: [f64; 2]) -> Path {
        let corners = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
        path(corners.map(|[x, y]| [u + x, v + y]).to_vec())
    }

    /// One region as it is, and cut upright and level: equal. Areas of some units are rounded to
    /// 1e-16 each, and there are fewer than 100 of them.
    #[test]
    fn cuts_make_no_difference() {
        let whole = [path(ell(0.0))];
        let upright = [
            rectangle([0.0, 0.0], [1.0, 2.0]),
            rectangle([1.0, 0.0], [1.0, 1.0]),
        ];
        let level = [
            rectangle([0.0, 1.0], [1.0, 1.0]),
            rectangle([0.0, 0.0], [0.7, 1.0]),
            rectangle([0.7, 0.0], [1.3, 1.0]),
        ];
        let lists: [&[Path]; 3] = [&whole, &upright, &level];
        for a in lists {
            for b in lists {
                assert!(uncut(a, b) < 1e-14, "{}", uncut(a, b));
            }
        }
        println!("{} pairs", lists.len().pow(2));
    }

    /// Differences by hand: outlines of the L are 8 long each.
    #[test]
    fn differences_are_areas_by_outlines() {
        let whole = [path(ell(0.0))];
        let moved = 1e-3;
        // The heights of its right sides are 2 in all, and of its left side too.
        let expected = 2.0 * 2.0 * moved / 16.0;
        let found = uncut(&whole, &[path(ell(moved))]);
        assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        let changes: [fn(&mut Path); 4] = [
            |path| path.weight += 1e-8,
            |path| path.matrix[0][1] *= 1.5,
            |path| path.offset[1] += 1e-8,
            |path| path.deviation[0] += 1e-8,
        ];
        for change in changes {
            let mut other = path(ell(0.0));
            change(&mut other);
            // Two regions of area 3 that have nothing to do with one another.
            let found = uncut(&whole, &[other]);
            assert!((found - 6.0 / 16.0).abs() < 1e-14, "{found}");
        }
        let twice = [path(ell(0.0)), path(ell(0.0))];
        let found = uncut(&whole, &twice);
        assert!((found - 3.0 / 24.0).abs() < 1e-14, "{found}");
        assert_eq!(uncut(&[], &[]), f64::INFINITY);
        println!("{} changes", changes.len() + 2);
    }
}
