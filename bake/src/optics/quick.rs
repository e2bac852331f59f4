//! A quicker test of the rays that clearly meet a facet or clearly miss it.
//!
//! It takes half of the operations of [`Triangle::reach`]. A ray too near an edge for it is left to
//! that test, so that the answers are the same.

use crate::optics::ray::Ray;
use crate::optics::triangle::{EDGE_ON, Triangle};
use glam::DVec3;

/// A facet with what the quick test needs.
pub(crate) struct Quick {
    /// Corner that positions are counted from, edge lengths.
    corner: DVec3,
    /// Unit normal on the front.
    pub normal: DVec3,
    /// Unit vectors in the facet, each perpendicular to an edge, inwards. The corner lies on the
    /// first edge and the last.
    inward: [DVec3; 3],
    /// Distance of the corner from the second edge, edge lengths.
    across: f64,
    /// Reciprocal of the length of the shortest edge.
    steepest: f64,
    /// Greatest distance of an origin from a corner, edge lengths.
    reach: f64,
}

/// Answer of the quick test for one ray.
pub(crate) struct Glance {
    /// Distance at which the ray meets the facet, edge lengths; [`Triangle::UNMET`] if it does not
    /// meet it or is not sure to.
    pub distance: f64,
    /// The top bit says that the ray passes an edge so near that [`Triangle::reach`] must decide.
    pub doubt: u64,
}

impl Quick {
    /// Prepares `facet` for rays whose origins are at most `reach` edge lengths from its corners.
    pub(crate) fn new(facet: &Triangle, reach: f64) -> Self {
        let [a, b, c] = facet.corners;
        let edges = [b - a, c - b, a - c];
        let inward = edges.map(|edge| facet.normal.cross(edge).normalize());
        let shortest = edges
            .map(DVec3::length)
            .into_iter()
            .fold(f64::MAX, f64::min);
        Quick {
            corner: a,
            normal: facet.normal,
            inward,
            across: inward[1].dot(a - b),
            steepest: 1.0 / shortest,
            reach,
        }
    }

    /// Looks whether `ray` meets the facet. A sure answer is that of [`Triangle::reach`], bit for
    /// bit.
    ///
    /// Let s be the distance inwards from an edge of the point where the ray crosses the plane of
    /// the facet, and cos the cosine of the ray's angle from the normal. The exact test compares
    /// |cos| s with the ray's slack, plus its grain over the edge's length, on either side of 0.
    /// Its own rounding adds at most 12 epsilon times the way to a corner. The rounding here (that
    /// of the height over the plane, the way to the crossing, the crossing, the tilt of the normal
    /// and the product) adds at most 40 epsilon times twice the reach or the distance. So beyond
    /// the sum of slack, grain and 64 epsilon times those, both tests agree.
    #[inline(always)]
    pub(crate) fn look(&self, ray: &Ray) -> Glance {
        let cosine = ray.direction.dot(self.normal);
        let side = if cosine < 0.0 { 1.0 } else { -1.0 };
        let way = ray.origin - self.corner;
        let height = way.dot(self.normal);
        let ahead = (cosine.abs() >= EDGE_ON) & (side * height >= -(side * ray.slack));
        let distance = -height / cosine;
        let distance = if distance > 0.0 { distance } else { 0.0 };
        let crossing = way + ray.direction * distance;
        let [first, second, third] = self.inward.map(|inward| crossing.dot(inward));
        let second = second + self.across;
        let least = if first < second { first } else { second };
        let least = if least < third { least } else { third };
        let inside = least * cosine.abs();
        let margin = ray.slack
            + ray.grain * self.steepest
            + 64.0 * f64::EPSILON * (2.0 * self.reach + distance);
        let meets = ahead & (inside > margin);
        let doubt = if ahead { inside.abs() - margin } else { 1.0 };
        Glance {
            distance: if meets { distance } else { Triangle::UNMET },
            doubt: doubt.to_bits(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Aims rays at points beside each edge of a plain facet and of a sliver, from the front and
    /// from behind, at 1e-18 to 1 edge lengths from the edge on either side. A sure answer is that
    /// of the exact test.
    ///
    /// For the plain facet, away from corners, answers are sure from 1e-11 on. The margin is some
    /// 1.6e-13: 64 epsilon times twice the reach of 4 and the distance of 2. The cosine is 0.1 at
    /// least, so that of the distance from the edge is 2e-12 at most.
    #[test]
    fn sure_answers_are_those_of_the_exact_test() {
        let plain = [
            DVec3::new(0.1, 0.2, -0.3),
            DVec3::new(1.3, 0.1, 0.4),
            DVec3::new(0.3, 0.9, 0.2),
        ];
        let sliver = [plain[0], plain[1], plain[0] + DVec3::new(0.6, 1e-7, 0.35)];
        let (mut cases, mut sure, mut met) = (0, 0, 0);
        for (which, corners) in [plain, sliver].into_iter().enumerate() {
            let facet = Triangle::new(corners).expect("has area");
            let quick = Quick::new(&facet, 4.0);
            for turn in 0..300 {
                let t = f64::from(turn);
                let away =
                    DVec3::new((1.1 * t).sin(), (2.3 * t).cos(), (0.7 * t).sin()).normalize();
                if away.dot(facet.normal).abs() < 0.1 {
                    continue;
                }
                for edge in 0..3 {
                    let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
                    let inward = facet.normal.cross(b - a).normalize();
                    for decade in -18..=0 {
                        for side in [-1.0, 0.0, 1.0] {
                            let off = inward * side * 10_f64.powi(decade);
                            let target = a.lerp(b, f64::from(turn % 11) / 10.0) + off;
                            let ray = Ray::new(target + away * 2.0, -away, 4.0);
                            let glance = quick.look(&ray);
                            let is_sure = glance.doubt >> 63 == 0;
                            let exact = facet.reach(&ray);
                            if is_sure {
                                assert_eq!(glance.distance, exact, "{which} {turn} {edge} {off}");
                            }
                            let clear = side != 0.0 && decade >= -11 && turn % 11 % 10 != 0;
                            assert!(is_sure || which == 1 || !clear, "{turn} {edge} {off}");
                            cases += 1;
                            sure += u32::from(is_sure);
                            met += u32::from(exact < Triangle::UNMET);
                        }
                    }
                }
            }
        }
        println!("{cases} rays, {sure} sure, {met} meet the facet");
        assert!(
            cases > 80_000 && sure > cases / 4 && met > cases / 10,
            "{cases} {sure} {met}"
        );
    }
}
