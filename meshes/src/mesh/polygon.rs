//! Cutting of a flat polygon, convex or not, into triangles.

use glam::{DVec2, DVec3};

use crate::mesh::error::Fault;

/// Most corners of a polygon that is not a fan, because ear clipping costs their square.
pub(crate) const MAX_CORNERS: usize = 1024;
/// Greatest distance of a corner from the polygon's plane, in units of the polygon's extent.
///
/// Files with six digits round corners by 1e-6. Beyond 1e-4 the choice of the diagonals changes how
/// the mirror reflects.
pub(crate) const FLAT: f64 = 1e-4;

/// Appends the triangles of the polygon `corners`, wound as it is, to `triangles`.
///
/// `face` is the number of the polygon in messages. Triangles are passed on as they are, degenerate
/// or not. A fan from the first corner is used where it is valid (for all convex polygons);
/// otherwise ears are clipped.
///
/// # Errors
/// Fails if the polygon is not flat to [`FLAT`], if it crosses itself, or if it is no fan and has
/// more than [`MAX_CORNERS`] corners.
///
/// # Panics
/// Panics if an index is out of range of `positions`.
pub(crate) fn cut(
    positions: &[DVec3],
    corners: &[u32],
    face: u32,
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), Fault> {
    if let [a, b, c] = *corners {
        triangles.push([a, b, c]);
        return Ok(());
    }
    let base = positions[corners[0] as usize];
    let points: Vec<DVec3> = corners
        .iter()
        .map(|&corner| positions[corner as usize] - base)
        .collect();
    let extent = points.iter().map(|p| p.length()).fold(0.0, f64::max);
    let mut area = DVec3::ZERO;
    for pair in points[1..].windows(2) {
        area += pair[0].cross(pair[1]);
    }
    let Some(normal) = area
        .try_normalize()
        .filter(|_| area.length() > 1e-10 * extent * extent)
    else {
        return Err(Fault::PolygonCrossed { face });
    };
    let off = points
        .iter()
        .map(|p| p.dot(normal).abs())
        .fold(0.0, f64::max);
    if off > FLAT * extent {
        return Err(Fault::PolygonNotFlat {
            face,
            relative: off / extent,
        });
    }
    let (x, y) = normal.any_orthonormal_pair();
    let mut flat: Vec<DVec2> = points
        .iter()
        .map(|p| DVec2::new(p.dot(x), p.dot(y)))
        .collect();
    if x.cross(y).dot(normal) < 0.0 {
        flat.iter_mut().for_each(|p| p.y = -p.y);
    }
    let thin = 1e-12 * extent * extent;
    let fans = (1..corners.len() - 1)
        .all(|i| (flat[i] - flat[0]).perp_dot(flat[i + 1] - flat[0]) > thin)
        // A fan of positive triangles turns only once if the angles at the first corner stay below
        // a full turn.
        && (flat[1] - flat[0]).perp_dot(flat[corners.len() - 1] - flat[0]) > thin;
    if fans {
        triangles.extend((1..corners.len() - 1).map(|i| [corners[0], corners[i], corners[i + 1]]));
        return Ok(());
    }
    if corners.len() > MAX_CORNERS {
        let (found, limit) = (corners.len() as u64, MAX_CORNERS as u64);
        return Err(Fault::TooLarge {
            what: "corners of one polygon",
            found,
            limit,
        });
    }
    clip_ears(&flat, corners, thin, triangles).ok_or(Fault::PolygonCrossed { face })
}

/// Clips the ears of a simple polygon, counter-clockwise in `flat`.
///
/// Returns `None` if the polygon crosses itself or no ear is left.
fn clip_ears(
    flat: &[DVec2],
    corners: &[u32],
    thin: f64,
    triangles: &mut Vec<[u32; 3]>,
) -> Option<()> {
    if crosses(flat) {
        return None;
    }
    let mut left: Vec<usize> = (0..flat.len()).collect();
    while left.len() > 3 {
        let n = left.len();
        let ear = (0..n).find(|&i| {
            let [a, b, c] = [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
            let turn = (flat[b] - flat[a]).perp_dot(flat[c] - flat[a]);
            turn > thin
                && left.iter().all(|&p| {
                    [a, b, c].contains(&p) || !inside(flat[p], [flat[a], flat[b], flat[c]])
                })
        })?;
        triangles
            .push([left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]].map(|i| corners[i]));
        left.remove(ear);
    }
    triangles.push([left[0], left[1], left[2]].map(|i| corners[i]));
    Some(())
}

/// Returns whether a point lies in a counter-clockwise triangle or on its edges.
fn inside(p: DVec2, [a, b, c]: [DVec2; 3]) -> bool {
    (b - a).perp_dot(p - a) >= 0.0
        && (c - b).perp_dot(p - b) >= 0.0
        && (a - c).perp_dot(p - c) >= 0.0
}

/// Returns whether two edges of a closed polygon that are not neighbours cross or touch.
///
/// The time is quadratic in the number of corners.
pub(crate) fn crosses(flat: &[DVec2]) -> bool {
    first_crossing(flat).is_some()
}

/// Returns the first edge of a closed polygon that crosses or touches a later edge which is not its
/// neighbour.
pub(crate) fn first_crossing(flat: &[DVec2]) -> Option<usize> {
    let n = flat.len();
    let side = |a: DVec2, b: DVec2, p: DVec2| (b - a).perp_dot(p - a);
    (0..n).find(|&i| {
        let (a, b) = (flat[i], flat[(i + 1) % n]);
        (i + 2..n).filter(|&j| (j + 1) % n != i).any(|j| {
            let (c, d) = (flat[j], flat[(j + 1) % n]);
            let boxes_meet = a.min(b).cmple(c.max(d)).all() && c.min(d).cmple(a.max(b)).all();
            boxes_meet
                && side(a, b, c) * side(a, b, d) <= 0.0
                && side(c, d, a) * side(c, d, b) <= 0.0
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cuts random star-shaped polygons, mostly concave, somewhere in space.
    ///
    /// Each must give n - 2 triangles, all wound as the polygon, whose areas add up to its area, so
    /// that they neither overlap nor leave gaps. Areas are of order 1, rounding is below 1e-13.
    #[test]
    fn concave_polygons_are_covered_once() {
        let mut state = 7_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let (mut cases, mut concave) = (0, 0);
        for n in 4..40_usize {
            for _ in 0..20 {
                let (x, y) = DVec3::new(random() - 0.5, random() - 0.5, 0.3)
                    .normalize()
                    .any_orthonormal_pair();
                let positions: Vec<DVec3> = (0..n)
                    .map(|i| {
                        let angle = std::f64::consts::TAU * (i as f64 + 0.5 * random()) / n as f64;
                        (x * angle.cos() + y * angle.sin()) * (0.2 + random())
                            + DVec3::new(5.0, -3.0, 2.0)
                    })
                    .collect();
                let corners: Vec<u32> = (0..n as u32).collect();
                let mut triangles = Vec::new();
                cut(&positions, &corners, 1, &mut triangles).expect("a simple polygon");
                let area = |t: &[u32]| {
                    let p = |k: usize| positions[t[k] as usize];
                    (2..t.len())
                        .map(|k| (p(k - 1) - p(0)).cross(p(k) - p(0)) / 2.0)
                        .sum::<DVec3>()
                };
                let normal = area(&corners).normalize();
                assert_eq!(triangles.len(), n - 2);
                assert!(triangles.iter().all(|t| area(t).dot(normal) > 0.0));
                let sum: f64 = triangles.iter().map(|t| area(t).length()).sum();
                assert!((sum - area(&corners).length()).abs() < 1e-13);
                concave += usize::from(triangles[0][0] != 0);
                cases += 1;
            }
        }
        assert_eq!(cases, 720);
        assert!(concave > 300, "{concave}");
    }
}
