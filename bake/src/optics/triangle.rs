//! A mirror facet and its ray test: in f64, edges and corners included, with an error bound instead
//! of an epsilon.
//!
//! The test asks on which side of the three edges the *line* of the ray passes. It computes triple
//! products of the direction, an edge, and the way from a corner to the ray's origin. So it stays
//! sharp at grazing incidence, where a test of the hit point in the plane loses digits as 1/cos.
//!
//! A ray is on an edge if it is within its own error bound of the edge. So a ray through a shared
//! edge or corner meets at least one of the facets there. A ray that rounding has put a hair behind
//! the next facet still meets that facet.

use crate::optics::ray::Ray;
use glam::DVec3;

/// Least cosine of the angle between a ray and the normal of a facet that it meets. Below it the
/// facet is seen edge-on, and its cross-section is below the rounding error of the ray.
pub(crate) const EDGE_ON: f64 = 1e-14;

/// A triangular facet in the cell frame. It mirrors on its front, from which its corners run
/// counter-clockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Triangle {
    /// Corners, edge lengths.
    pub corners: [DVec3; 3],
    /// Unit normal on the front.
    pub normal: DVec3,
    /// Lengths of the edges 0-1, 1-2, 2-0.
    lengths: [f64; 3],
    /// True for a surface of glass, which rays meet from either side.
    two_sided: bool,
}

/// The point where a ray meets a facet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Contact {
    /// Distance along the ray, edge lengths, >= 0.
    pub distance: f64,
    /// True if the ray comes from the front.
    pub front: bool,
}

/// A facet as all rays of one direction see it: the part of the test that does not depend on where
/// a ray starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Aspect {
    /// A corner on each edge.
    pub corners: [DVec3; 3],
    /// Gradient of each edge's triple product by the ray's origin. It points to the inner side.
    pub inward: [DVec3; 3],
    /// Lengths of the edges.
    pub lengths: [f64; 3],
    /// Unit normal on the front.
    pub normal: DVec3,
    /// Cosine of the angle between the rays and the normal.
    pub cosine: f64,
    /// Side that the rays come from: 1 for the front, -1 for the back.
    pub side: f64,
    /// Rule for a ray within its error of an edge: 1 if it meets the facet, -1 if it passes.
    edge: f64,
}

impl Aspect {
    /// Returns the distance at which `ray` meets the facet, edge lengths, or `None`. The ray must
    /// have the direction of this aspect.
    #[inline(always)]
    pub(crate) fn meet(&self, ray: &Ray) -> Option<f64> {
        let height = (ray.origin - self.corners[0]).dot(self.normal);
        if self.side * height < -(self.side * ray.slack) {
            return None;
        }
        // A ray within its error of an edge meets the facet from the front and passes it from the
        // back. So a ray that grazes a ridge or a rim goes on and is not caught by the back of the
        // facet beyond. Within glass no ray may pass.
        let on = |edge: usize| {
            (ray.origin - self.corners[edge]).dot(self.inward[edge])
                >= -(self.edge * (ray.slack * self.lengths[edge] + ray.grain))
        };
        let distance = -height / self.cosine;
        (on(0) && on(1) && on(2)).then_some(if distance > 0.0 { distance } else { 0.0 })
    }
}

impl Triangle {
    /// Makes a facet of its corners, or `None` if they span no plane (zero area).
    pub(crate) fn new(corners: [DVec3; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let normal = normal(&corners)?;
        Some(Triangle {
            corners,
            normal,
            lengths: [(b - a).length(), (c - b).length(), (a - c).length()],
            two_sided: false,
        })
    }

    /// Returns the facet as a surface of glass, which rays meet from either side.
    pub(crate) fn two_sided(self) -> Self {
        Triangle {
            two_sided: true,
            ..self
        }
    }

    /// Returns the facet moved by `offset`.
    pub(crate) fn moved(&self, offset: DVec3) -> Self {
        Triangle {
            corners: self.corners.map(|corner| corner + offset),
            ..*self
        }
    }

    /// Returns the facet as rays along `direction` see it, or `None` if they see it edge-on.
    #[inline(always)]
    pub(crate) fn along(&self, direction: DVec3) -> Option<Aspect> {
        let cosine = direction.dot(self.normal);
        if cosine.abs() < EDGE_ON {
            return None;
        }
        let side = if cosine < 0.0 { 1.0 } else { -1.0 };
        let [a, b, c] = self.corners;
        Some(Aspect {
            corners: self.corners,
            inward: [
                (b - a).cross(direction) * side,
                (c - b).cross(direction) * side,
                (a - c).cross(direction) * side,
            ],
            lengths: self.lengths,
            normal: self.normal,
            cosine,
            side,
            edge: if self.two_sided { 1.0 } else { side },
        })
    }

    /// Returns the point where `ray` meets the facet, or `None`.
    ///
    /// A ray that starts on the facet and leaves to its front does not meet it. A ray that starts
    /// on it, within the ray's error bound, and heads into it meets it at the distance 0.
    #[inline(always)]
    pub(crate) fn meet(&self, ray: &Ray) -> Option<Contact> {
        let aspect = self.along(ray.direction)?;
        Some(Contact {
            distance: aspect.meet(ray)?,
            front: aspect.side > 0.0,
        })
    }

    /// Distance that [`Triangle::reach`] returns for a ray that does not meet the facet.
    pub(crate) const UNMET: f64 = f64::MAX;

    /// Returns the distance at which `ray` meets the facet, edge lengths, or [`Triangle::UNMET`].
    ///
    /// The result is that of [`Triangle::meet`], without a branch. No ray meets a facet of glass
    /// here.
    #[inline(always)]
    pub(crate) fn reach(&self, ray: &Ray) -> f64 {
        let cosine = ray.direction.dot(self.normal);
        let side = if cosine < 0.0 { 1.0 } else { -1.0 };
        let height = (ray.origin - self.corners[0]).dot(self.normal);
        let ahead = side * height >= -(side * ray.slack);
        let mut meets = (cosine.abs() >= EDGE_ON) & ahead;
        for edge in 0..3 {
            let (from, to) = (self.corners[edge], self.corners[(edge + 1) % 3]);
            let inward = (to - from).cross(ray.direction) * side;
            let margin = -(side * (ray.slack * self.lengths[edge] + ray.grain));
            meets &= (ray.origin - from).dot(inward) >= margin;
        }
        let distance = -height / cosine;
        let distance = if distance > 0.0 { distance } else { 0.0 };
        if meets { distance } else { Triangle::UNMET }
    }

    /// Returns the weights of the corners at `point` of the facet. They are not negative and sum to
    /// 1.
    ///
    /// If rounding has put `point` beside the facet, it is brought back.
    pub(crate) fn weights(&self, point: DVec3) -> [f64; 3] {
        let [a, b, c] = self.corners;
        let (along, beside, way) = (b - a, c - a, point - a);
        let doubled = along.cross(beside).dot(self.normal);
        let second = (way.cross(beside).dot(self.normal) / doubled).clamp(0.0, 1.0);
        let third = (along.cross(way).dot(self.normal) / doubled).clamp(0.0, 1.0 - second);
        [1.0 - second - third, second, third]
    }

    /// Returns the error bound, edge lengths, of the point `distance` along a ray in `direction`,
    /// as a point of this facet's plane.
    ///
    /// Rounding of the height over the plane shifts the point along the ray by that height over the
    /// cosine.
    pub(crate) fn slack_after(&self, direction: DVec3, distance: f64, reach: f64) -> f64 {
        slack_after(direction.dot(self.normal), distance, reach)
    }
}

/// Returns what [`Triangle::slack_after`] does, of a ray whose direction has the component `along`
/// on the normal of the facet.
#[inline(always)]
pub(crate) fn slack_after(along: f64, distance: f64, reach: f64) -> f64 {
    16.0 * f64::EPSILON * (reach + distance) / along.abs()
}

/// Returns the unit normal of a planar polygon, or `None` without area.
///
/// It points to the side from which the corners run counter-clockwise. It is perpendicular to the
/// longest side within rounding, even for a sliver. The rounding of a cross product tilts a sliver
/// by 1e-16 / height about any axis, which lifts its ends off its plane by as much. Here such a
/// tilt is left only about the longest side, where it lifts no corner by more than rounding.
pub(crate) fn normal(corners: &[DVec3]) -> Option<DVec3> {
    let first = *corners.first()?;
    let sum: DVec3 = corners
        .windows(2)
        .map(|w| (w[0] - first).cross(w[1] - first))
        .sum();
    let sides = (0..corners.len()).map(|i| corners[(i + 1) % corners.len()] - corners[i]);
    let along = sides
        .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?
        .try_normalize()?;
    (sum - along * along.dot(sum)).try_normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks slivers: their corners have unit coordinates, known to 1.1e-16 each, and lie in their
    /// planes to that accuracy.
    #[test]
    fn slivers_lie_in_their_planes() {
        let (mut cases, mut worst) = (0, 0.0_f64);
        for turn in 0..200 {
            let axis = DVec3::new(
                (1.7 * f64::from(turn)).sin(),
                0.3,
                (2.3 * f64::from(turn)).cos(),
            );
            let turned = glam::DMat3::from_axis_angle(axis.normalize(), f64::from(turn));
            for decade in -13..=0 {
                let high = 10_f64.powi(decade);
                let corners =
                    [DVec3::ZERO, DVec3::X, DVec3::new(0.4, high, 0.0)].map(|p| turned * p);
                let normal = normal(&corners).expect("has area");
                let lift = corners.map(|p| normal.dot(p - corners[0]).abs());
                worst = lift.into_iter().fold(worst, f64::max);
                cases += 1;
            }
        }
        println!("{cases} slivers, corners within {worst:.1e} of their planes");
        assert_eq!(cases, 200 * 14);
        assert!(worst < 4.0 * f64::EPSILON, "{worst}");
    }

    /// Rays from all around, towards the facet and beside it, to corners and along edges, from the
    /// front and from behind: the distance without a branch is that of the test, to the last bit.
    #[test]
    fn reach_is_the_distance_of_meet() {
        let facet = Triangle::new([
            DVec3::new(0.1, 0.2, -0.3),
            DVec3::new(1.3, 0.1, 0.4),
            DVec3::new(0.3, 0.9, 0.2),
        ])
        .expect("has area");
        let [a, b, c] = facet.corners;
        let (mut cases, mut met) = (0, 0);
        for i in 0..400 {
            let t = f64::from(i);
            let origin = DVec3::new((1.1 * t).sin(), (2.3 * t).cos(), (0.7 * t).sin()) * 2.0;
            let along = (b - a) * f64::from(i % 5) / 4.0 + a;
            let inside = a * 0.5 + b * 0.3 + c * 0.2;
            let beside = a * 0.7 + b * 0.7 - c * 0.4;
            for target in [a, b, c, along, inside, beside] {
                for (start, way) in [(origin, target - origin), (target, origin - target)] {
                    let ray = Ray::new(start, way.normalize(), 3.0);
                    let alone = facet.meet(&ray).map_or(Triangle::UNMET, |met| met.distance);
                    assert_eq!(facet.reach(&ray), alone, "{start} {way}");
                    cases += 1;
                    met += u32::from(alone < Triangle::UNMET);
                }
            }
        }
        println!("{met} of {cases} rays meet the facet");
        assert!(cases == 400 * 12 && met > 1000, "{met}");
    }

    fn unit() -> Triangle {
        Triangle::new([DVec3::ZERO, DVec3::X, DVec3::Y]).expect("has area")
    }

    fn down(x: f64, y: f64) -> Ray {
        Ray::new(DVec3::new(x, y, 1.0), -DVec3::Z, 2.0)
    }

    #[test]
    fn inside_edges_corners_and_outside() {
        let facet = unit();
        let hits = [
            (0.2, 0.3),
            (0.0, 0.5),
            (0.5, 0.0),
            (0.5, 0.5),
            (0.0, 0.0),
            (1.0, 0.0),
            (0.0, 1.0),
        ];
        for (x, y) in hits {
            let contact = facet
                .meet(&down(x, y))
                .unwrap_or_else(|| panic!("({x}, {y}) is on the facet"));
            assert_eq!(
                contact,
                Contact {
                    distance: 1.0,
                    front: true
                }
            );
        }
        for (x, y) in [
            (-1e-12, 0.5),
            (0.5, -1e-12),
            (0.5 + 1e-12, 0.5 + 1e-12),
            (2.0, 2.0),
        ] {
            assert_eq!(facet.meet(&down(x, y)), None, "({x}, {y}) is off the facet");
        }
    }

    #[test]
    fn back_and_behind() {
        let facet = unit();
        let up = Ray::new(DVec3::new(0.2, 0.2, -1.0), DVec3::Z, 2.0);
        assert_eq!(
            facet.meet(&up),
            Some(Contact {
                distance: 1.0,
                front: false
            })
        );
        let behind = Ray::new(DVec3::new(0.2, 0.2, -1.0), -DVec3::Z, 2.0);
        assert_eq!(facet.meet(&behind), None);
    }

    #[test]
    fn a_ray_that_starts_on_the_facet() {
        let facet = unit();
        let start = DVec3::new(0.25, 0.25, -1e-17);
        let into = Ray::new(start, DVec3::new(0.6, 0.0, -0.8), 2.0);
        assert_eq!(
            facet.meet(&into).map(|c| c.distance),
            Some(0.0),
            "heading in by rounding: met at once"
        );
        let away = Ray::new(start, DVec3::new(0.6, 0.0, 0.8), 2.0);
        assert_eq!(facet.meet(&away), None, "leaving: not met");
    }

    #[test]
    fn no_area_no_facet() {
        assert_eq!(Triangle::new([DVec3::ZERO, DVec3::X, DVec3::X * 2.0]), None);
    }

    /// Checks the weights of points on the facet and beside it. The coordinates are sums of a few
    /// eighths, so the weights are exact but for one division by the doubled area 1.
    #[test]
    fn weights_are_those_of_the_corners_and_never_negative() {
        let facet = unit();
        let cases = [
            ([0.25, 0.5], [0.25, 0.25, 0.5]),
            ([0.0, 0.0], [1.0, 0.0, 0.0]),
            ([0.5, 0.5], [0.0, 0.5, 0.5]),
            // Beside an edge, a point is brought back to it.
            ([-0.125, 0.5], [0.5, 0.0, 0.5]),
            ([0.5, -0.125], [0.5, 0.5, 0.0]),
            ([0.625, 0.5], [0.0, 0.625, 0.375]),
            ([1.125, 0.5], [0.0, 1.0, 0.0]),
        ];
        for ([x, y], expected) in cases {
            assert_eq!(facet.weights(DVec3::new(x, y, 0.0)), expected, "({x}, {y})");
        }
        assert_eq!(cases.len(), 7);
    }
}
