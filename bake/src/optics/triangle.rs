//! A mirror facet and its ray test: in f64, edges and corners included, with an error bound instead
//! of an epsilon.
//!
//! The test asks on which side of the three edges the *line* of the ray passes (triple products of
//! direction, edge and the way from a corner to the ray's origin), so it stays sharp at grazing
//! incidence, where a test of the hit point in the plane loses digits as 1/cos. A ray is on an edge
//! when it is within its own error bound of it, so that a ray through a shared edge or corner meets
//! at least one of the facets there, and one that lies, by rounding, a hair behind the next facet
//! still meets that one.

use crate::optics::ray::Ray;
use glam::DVec3;

/// Facets closer to parallel with the ray than this (cosine) are seen edge-on and not met: their
/// cross-section is below the rounding error of the ray.
pub(crate) const EDGE_ON: f64 = 1e-14;

/// A triangular facet in the cell frame: a mirror from the front, where its corners run
/// counter-clockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Triangle {
    /// Corners, edge lengths.
    pub corners: [DVec3; 3],
    /// Unit normal on the front.
    pub normal: DVec3,
    /// Lengths of the edges 0-1, 1-2, 2-0.
    lengths: [f64; 3],
    /// Whether it counts from behind as it does from the front: a surface of glass.
    two_sided: bool,
}

/// Where a ray meets a facet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Contact {
    /// Distance along the ray, edge lengths, >= 0.
    pub distance: f64,
    /// Whether the ray comes from the front.
    pub front: bool,
}

/// A facet as all rays of one direction see it: what of its test does not depend on where a ray
/// starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Aspect {
    /// A corner on each edge.
    pub corners: [DVec3; 3],
    /// For each edge the gradient of the triple product by the ray's origin: it points to the inner
    /// side.
    pub inward: [DVec3; 3],
    /// Lengths of the edges.
    pub lengths: [f64; 3],
    /// Unit normal on the front.
    pub normal: DVec3,
    /// Of the angle between the rays and the normal.
    pub cosine: f64,
    /// 1 where the rays come from the front, -1 from the back.
    pub side: f64,
    /// 1 where a ray within its error of an edge meets the facet, -1 where it passes.
    edge: f64,
}

impl Aspect {
    /// The distance at which `ray`, which has the aspect's direction, meets the facet, or `None`.
    #[inline]
    pub(crate) fn meet(&self, ray: &Ray) -> Option<f64> {
        let height = (ray.origin - self.corners[0]).dot(self.normal);
        if self.side * height < -(self.side * ray.slack) {
            return None;
        }
        // A ray within its error of an edge meets the facet from the front and passes it from the
        // back: one that grazes a ridge or a rim goes on, it is not caught by the back of the facet
        // beyond. Within glass none may pass.
        let on = |edge: usize| {
            (ray.origin - self.corners[edge]).dot(self.inward[edge])
                >= -(self.edge * (ray.slack * self.lengths[edge] + ray.grain))
        };
        let distance = -height / self.cosine;
        (on(0) && on(1) && on(2)).then_some(if distance > 0.0 { distance } else { 0.0 })
    }
}

impl Triangle {
    /// A facet from its corners. `None` where they span no plane (zero area).
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

    /// The facet as a surface of glass, which rays meet from either side.
    pub(crate) fn two_sided(self) -> Self {
        Triangle {
            two_sided: true,
            ..self
        }
    }

    /// The facet moved by `offset`.
    pub(crate) fn moved(&self, offset: DVec3) -> Self {
        Triangle {
            corners: self.corners.map(|corner| corner + offset),
            ..*self
        }
    }

    /// The facet as rays along `direction` see it; `None` edge-on.
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

    /// Where `ray` meets the facet, or `None`.
    ///
    /// A facet that the ray starts on, leaving to its front, is not met; one that it starts on
    /// (within the ray's error bound) heading into is met at distance 0.
    #[inline]
    pub(crate) fn meet(&self, ray: &Ray) -> Option<Contact> {
        let aspect = self.along(ray.direction)?;
        Some(Contact {
            distance: aspect.meet(ray)?,
            front: aspect.side > 0.0,
        })
    }

    /// Weights of the corners at `point` of the facet: not negative, adding up to 1. `point` is
    /// brought back to the facet where rounding has it beside.
    pub(crate) fn weights(&self, point: DVec3) -> [f64; 3] {
        let [a, b, c] = self.corners;
        let (along, beside, way) = (b - a, c - a, point - a);
        let doubled = along.cross(beside).dot(self.normal);
        let second = (way.cross(beside).dot(self.normal) / doubled).clamp(0.0, 1.0);
        let third = (along.cross(way).dot(self.normal) / doubled).clamp(0.0, 1.0 - second);
        [1.0 - second - third, second, third]
    }

    /// Error bound of the point `distance` along a ray in `direction` as a point of this facet's
    /// plane, edge lengths: rounding of the height over the plane, divided by the cosine, shifts
    /// the point along the ray.
    pub(crate) fn slack_after(&self, direction: DVec3, distance: f64, reach: f64) -> f64 {
        16.0 * f64::EPSILON * (reach + distance) / direction.dot(self.normal).abs()
    }
}

/// Unit normal of a planar polygon, on the side from which its corners run counter-clockwise;
/// `None` without area.
///
/// It is square to the longest side within rounding, whatever the height over that side: rounding
/// of a cross product tilts a sliver by 1e-16 / height about any axis, which lifts its ends off its
/// plane by as much. About the longest side it stays tilted so, which lifts no corner by more than
/// rounding.
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

    /// Corners of unit coordinates are known to 1.1e-16 each, and so is the plane where they are.
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
}
