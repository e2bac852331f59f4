//! Up to eight facets side by side, in f32: a quick test that says which of them a ray may meet.
//!
//! The space is sheared so that the ray runs along the third axis from the origin, as in Woop,
//! Benthin and Wald, "Watertight Ray/Triangle Intersection" (JCGT 2013). Seen along the ray, each
//! facet is then a flat triangle, and its three edges turn about the origin to one side if the ray
//! passes inside. The test lets a ray pass outside by more than all rounding, so it never drops a
//! facet that [`Triangle::meet`] takes.

use crate::optics::{Ray, Triangle};
use glam::{DVec3, Vec4};

/// Number of facets in a block.
pub(crate) const SIDE_BY_SIDE: usize = 8;

/// Number of vectors that hold a number for each facet.
const VECTORS: usize = SIDE_BY_SIDE / 4;

/// Up to [`SIDE_BY_SIDE`] facets.
pub(crate) struct Block {
    /// Corners, by corner and axis, counted from the centre of the hierarchy, edge lengths.
    corners: [[[Vec4; 3]; 3]; VECTORS],
    /// Numbers of the facets.
    pub facets: [u32; SIDE_BY_SIDE],
    /// Bits of the places that hold facets.
    used: u32,
    /// Upper bound on the length of an edge, plus the padding of the boxes, edge lengths.
    size: f32,
}

impl Block {
    /// Makes the block of the facets with these `numbers`.
    ///
    /// Positions are counted from `centre`. `padding` is that of the boxes, edge lengths.
    pub(crate) fn new(facets: &[Triangle], numbers: &[u32], centre: DVec3, padding: f64) -> Self {
        let mut block = Block {
            corners: [[[Vec4::ZERO; 3]; 3]; VECTORS],
            facets: [0; SIDE_BY_SIDE],
            used: (1 << numbers.len()) - 1,
            size: 0.0,
        };
        let mut size = 0.0_f64;
        for (place, &number) in numbers.iter().enumerate() {
            let corners = facets[number as usize].corners;
            block.facets[place] = number;
            for (corner, at) in corners.iter().enumerate() {
                let at = *at - centre;
                for axis in 0..3 {
                    block.corners[place / 4][corner][axis][place % 4] = at[axis] as f32;
                }
                size = size.max(corners[(corner + 1) % 3].distance(corners[corner]));
            }
        }
        // A number in f32 is off by a part of 2^-24.
        block.size = ((size + padding) * (1.0 + 1e-6)) as f32;
        block
    }

    /// Returns the places of the facets that the ray of `sight` may meet, as a set of bits.
    #[inline(always)]
    pub(crate) fn seen(&self, sight: &Sight) -> u32 {
        let margin = Vec4::splat(sight.part * self.size + sight.rest);
        let mut seen = 0;
        for (vector, corners) in self.corners.iter().enumerate() {
            let [a, b, c] = sheared(corners, sight);
            let (u, v, w) = (turn(a, b), turn(b, c), turn(c, a));
            let inside = u.min(v).min(w).cmpge(-margin) | u.max(v).max(w).cmple(margin);
            seen |= inside.bitmask() << (4 * vector);
        }
        seen & self.used
    }
}

/// Returns the corners of four facets as the ray of `sight` sees them: two coordinates across it.
#[inline(always)]
fn sheared(corners: &[[Vec4; 3]; 3], sight: &Sight) -> [(Vec4, Vec4); 3] {
    let [i, j, k] = sight.axes;
    [0, 1, 2].map(|corner| {
        let at = &corners[corner];
        let z = at[k] - sight.origin[2];
        let x = (at[i] - sight.origin[0]) - sight.shear[0] * z;
        let y = (at[j] - sight.origin[1]) - sight.shear[1] * z;
        (x, y)
    })
}

/// Returns on which side of an edge the origin lies, times the length of the edge.
#[inline(always)]
fn turn(from: (Vec4, Vec4), to: (Vec4, Vec4)) -> Vec4 {
    from.0 * to.1 - from.1 * to.0
}

/// Ray as the test of a block needs it.
pub(crate) struct Sight {
    /// Axes of space, that along which the ray is steepest last.
    axes: [usize; 3],
    /// Start of the ray, by those axes, counted from the centre of the hierarchy, edge lengths.
    origin: [f32; 3],
    /// Way along the first two axes per way along the last.
    shear: [f32; 2],
    /// Part of the size of a block that counts into the margin of its test, edge lengths.
    part: f32,
    /// Margin of a block without size, square edge lengths.
    rest: f32,
}

impl Sight {
    /// Makes the sight along `ray`, which is seen from `origin`, a point of its line.
    ///
    /// `origin` is counted from the centre of the hierarchy; all facets are within `radius` of it.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray, origin: DVec3, radius: f64) -> Self {
        let steep = ray.direction.abs();
        let k = if steep.x > steep.y && steep.x > steep.z {
            0
        } else if steep.y > steep.z {
            1
        } else {
            2
        };
        let axes = [(k + 1) % 3, (k + 2) % 3, k];
        // Let M be the sum of the radius and the distance of the origin, and r = 2^-24. A sheared
        // coordinate is x - s z, where |x|, |z| <= M and |s| <= 1. Corners and origin in f32 put x
        // and z off by M r each, the differences by M r each, s and the product by M r each, and
        // the last difference by 2 M r. So the coordinate is off by less than e = 16 M r. If a ray
        // meets a facet of size L, padding included, all sheared coordinates of the corners are
        // below X = 2 L. Their errors put a turn off by 4 e X + 2 e^2 at most, and its own rounding
        // by 4 r (X + e)^2 < e (X + e), because X < 4 M. The margin 16 e (L + e) is more.
        let error = (-20_f64).exp2() * (radius + origin.length());
        // A turn is the triple product that the exact test computes, divided by the steepest
        // component, which is 0.57 at least. So the slack of the exact test counts twice.
        let part = 16.0 * error + 2.0 * ray.slack;
        let rest = 16.0 * error * error + 2.0 * ray.grain;
        let over = 1.0 / ray.direction[k];
        Sight {
            axes,
            origin: axes.map(|axis| origin[axis] as f32),
            shear: [axes[0], axes[1]].map(|axis| (ray.direction[axis] * over) as f32),
            part: (part * (1.0 + 1e-6)) as f32,
            rest: (rest * (1.0 + 1e-6)) as f32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a number in [-1, 1) that follows from `k`.
    fn spread(k: u32) -> f64 {
        f64::from(k.wrapping_mul(2_654_435_769)) / 2_147_483_648.0 - 1.0
    }

    /// No facet that the exact test takes is dropped: facets of all sizes, down to slivers, met at
    /// their corners, on their edges and inside, from near and far, along the axes and obliquely.
    /// Of the facets that a ray passes widely, few are kept.
    #[test]
    fn no_facet_that_is_met_is_dropped() {
        let (mut met, mut wide, mut kept) = (0, 0, 0);
        for k in 0..4000_u32 {
            let at = |n: u32| spread(k * 16 + n);
            let centre = DVec3::new(at(0), at(1), at(2)) * 0.1;
            let size = 10_f64.powi(-((k % 6) as i32));
            let low = DVec3::new(at(3), at(4), at(5));
            let along = DVec3::new(at(6), at(7), at(8)) * size;
            let across = DVec3::new(at(9), at(10), at(11)) * size;
            let flat = if k % 7 == 0 { 1e-9 } else { 1.0 };
            let corners = [low, low + along, low + along * 0.3 + across * flat];
            let Some(facet) = Triangle::new(corners) else {
                continue;
            };
            let facets = [facet];
            let radius = corners.map(|c| c.distance(centre)).into_iter();
            let radius = radius.fold(0.0, f64::max);
            let padding = radius * (-19_f64).exp2();
            let block = Block::new(&facets, &[0], centre, padding);
            let [a, b, c] = corners;
            let mixed = a * 0.2 + b * 0.5 + c * 0.3;
            let way = match k % 5 {
                0 => DVec3::X,
                1 => DVec3::NEG_Y,
                _ => DVec3::new(at(12), at(13), at(14)).normalize(),
            };
            let beside = low + (along + across) * 3.0 + way.cross(along);
            for target in [a, b, c, (a + b) / 2.0, b * 0.9 + c * 0.1, mixed, beside] {
                for distance in [0.0, 1e-3, 0.7, 3.0] {
                    let ray = Ray::new(target - way * distance, way, radius + distance);
                    let origin = ray.origin - centre;
                    let seen = block.seen(&Sight::new(&ray, origin, radius));
                    let taken = facet.meet(&ray).is_some();
                    assert!(seen == 1 || !taken, "{k} {target} {distance}");
                    met += u32::from(taken);
                    if target == beside && !taken && k % 6 < 2 {
                        wide += 1;
                        kept += seen;
                    }
                }
            }
        }
        println!("{met} facets met, {kept} of {wide} passed facets kept");
        assert!(met > 10_000 && wide > 1_000, "{met} {wide}");
        assert!(kept * 20 < wide, "{kept} of {wide}");
    }
}
