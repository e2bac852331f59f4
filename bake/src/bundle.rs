//! Many rays through a hierarchy at once, for meshes that no program fits (curved, or of many different cells).
//!
//! Rays that enter side by side mostly meet the same facets. So the rays of a run are sorted by where they enter; after
//! each reflection those of a neighbourhood are sorted by the facets that they come from; and up to 64 that follow
//! each other go down the hierarchy as one [`Bundle`], by bounds on all of them, and are tested against each
//! candidate side by side. The test is [`Facet::meet`], operation by operation, so every ray has the outcome that it
//! has alone, bit for bit.

#![allow(
    clippy::needless_range_loop,
    reason = "the same lane of several arrays; iterators hide that"
)]

use crate::lanes::LANES;
use crate::ray::Ray;
use crate::scene::Nearest;
use crate::triangle::{EDGE_ON, Facet};
use glam::DVec3;

type Reals = [f64; LANES];

/// Rays of one neighbourhood: their paths fit the second-level cache.
pub const NEIGHBOURS: usize = 2048;

/// No facet.
const NONE: u64 = u64::MAX;

/// Up to [`LANES`] rays, and the nearest facet of each so far.
pub struct Bundle {
    origin: [Reals; 3],
    direction: [Reals; 3],
    slack: Reals,
    grain: Reals,
    distance: Reals,
    facet: [u64; LANES],
    count: usize,
}

/// Bounds on the rays of a bundle.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    low: [f64; 3],
    high: [f64; 3],
    /// Least and greatest direction component by axis,
    slowest: [f64; 3],
    fastest: [f64; 3],
    /// and 1 over them.
    inverse: [[f64; 2]; 3],
}

/// Direction components smaller than this do not bound the time that a bundle is in a box.
const LEVEL: f64 = 1e-9;

impl Bundle {
    /// A bundle of no rays.
    pub fn new() -> Self {
        Bundle {
            origin: [[0.0; LANES]; 3],
            direction: [[0.0; LANES]; 3],
            slack: [0.0; LANES],
            grain: [0.0; LANES],
            distance: [0.0; LANES],
            facet: [NONE; LANES],
            count: 0,
        }
    }

    /// Takes `rays`, at most [`LANES`] and at least one; lanes that are left repeat the last.
    pub fn fill<'a>(&mut self, rays: impl Iterator<Item = &'a Ray>) {
        self.count = 0;
        for (lane, ray) in rays.enumerate() {
            self.put(lane, ray);
            self.count += 1;
        }
        let last = self.count - 1;
        for lane in self.count..LANES {
            for axis in 0..3 {
                self.origin[axis][lane] = self.origin[axis][last];
                self.direction[axis][lane] = self.direction[axis][last];
            }
            self.slack[lane] = self.slack[last];
            self.grain[lane] = self.grain[last];
        }
        // Lanes beyond the whole vectors of the rays look for nothing.
        self.distance = [0.0; LANES];
        self.distance[..self.count.next_multiple_of(8).min(LANES)].fill(f64::INFINITY);
        self.facet = [NONE; LANES];
    }

    fn put(&mut self, lane: usize, ray: &Ray) {
        for axis in 0..3 {
            self.origin[axis][lane] = ray.origin[axis];
            self.direction[axis][lane] = ray.direction[axis];
        }
        self.slack[lane] = ray.slack;
        self.grain[lane] = ray.grain;
    }

    /// What the ray in `lane` met, `facets` being those that were offered.
    pub fn nearest(&self, lane: usize, facets: &[Facet]) -> Nearest {
        let direction = DVec3::from_array(self.direction.map(|axis| axis[lane]));
        let facet = (self.facet[lane] != NONE).then_some(self.facet[lane] as usize);
        Nearest {
            facet,
            distance: self.distance[lane],
            front: facet.is_some_and(|facet| direction.dot(facets[facet].normal) < 0.0),
        }
    }

    /// Bounds on the rays, origins counted from `centre`.
    #[inline(always)]
    pub fn bounds(&self, centre: DVec3) -> Bounds {
        let least = |of: &Reals| fold(of, f64::min);
        let most = |of: &Reals| fold(of, f64::max);
        let axes = [0, 1, 2];
        let slowest = axes.map(|axis| least(&self.direction[axis]));
        let fastest = axes.map(|axis| most(&self.direction[axis]));
        Bounds {
            low: axes.map(|axis| least(&self.origin[axis]) - centre[axis]),
            high: axes.map(|axis| most(&self.origin[axis]) - centre[axis]),
            slowest,
            fastest,
            inverse: axes.map(|axis| [1.0 / slowest[axis], 1.0 / fastest[axis]]),
        }
    }

    /// The distance beyond which no ray looks.
    #[inline(always)]
    pub fn limit(&self) -> f64 {
        fold(&self.distance, f64::max)
    }

    /// [`Nearest::offer`] for every ray.
    #[inline(always)]
    pub fn offer(&mut self, index: usize, facet: &Facet) {
        let [dx, dy, dz] = &self.direction;
        let [ox, oy, oz] = &self.origin;
        // Whole vectors: the lanes that are left over repeat the last ray.
        let lanes = self.count.next_multiple_of(8).min(LANES);
        let normal = facet.normal;
        let [a, b, c] = facet.corners;
        let (mut cosine, mut height): (Reals, Reals) = ([0.0; LANES], [0.0; LANES]);
        let mut ahead = [0u64; LANES];
        for lane in 0..lanes {
            cosine[lane] = dx[lane] * normal.x + dy[lane] * normal.y + dz[lane] * normal.z;
            let (x, y, z) = (a.x - ox[lane], a.y - oy[lane], a.z - oz[lane]);
            height[lane] = -(x * normal.x + y * normal.y + z * normal.z);
            let front = cosine[lane] < 0.0;
            let behind = if front {
                height[lane] < -self.slack[lane]
            } else {
                height[lane] > -self.slack[lane]
            };
            ahead[lane] = u64::from((cosine[lane].abs() >= EDGE_ON) & !behind);
        }
        if ahead.iter().fold(0, |any, lane| any | lane) == 0 {
            return;
        }
        let [ab, bc, ca] = facet.lengths();
        for lane in 0..lanes {
            let (px, py, pz) = (ox[lane], oy[lane], oz[lane]);
            let (d0, d1, d2) = (dx[lane], dy[lane], dz[lane]);
            let (ax, ay, az) = (a.x - px, a.y - py, a.z - pz);
            let (bx, by, bz) = (b.x - px, b.y - py, b.z - pz);
            let (cx, cy, cz) = (c.x - px, c.y - py, c.z - pz);
            let front = cosine[lane] < 0.0;
            let side = if front { -1.0 } else { 1.0 };
            let (slack, grain) = (self.slack[lane], self.grain[lane]);
            // Cross and dot products in the order of glam's.
            let one =
                d0 * (ay * bz - by * az) + d1 * (az * bx - bz * ax) + d2 * (ax * by - bx * ay);
            let two =
                d0 * (by * cz - cy * bz) + d1 * (bz * cx - cz * bx) + d2 * (bx * cy - cx * by);
            let three =
                d0 * (cy * az - ay * cz) + d1 * (cz * ax - az * cx) + d2 * (cx * ay - ax * cy);
            let on = (side * one >= side * (slack * ab + grain))
                & (side * two >= side * (slack * bc + grain))
                & (side * three >= side * (slack * ca + grain));
            let quotient = -height[lane] / cosine[lane];
            let distance = if quotient > 0.0 { quotient } else { 0.0 };
            let known = self.distance[lane];
            let nearer =
                (distance < known) | ((distance == known) & ((index as u64) < self.facet[lane]));
            let met = (ahead[lane] != 0) & on & nearer;
            self.distance[lane] = if met { distance } else { known };
            self.facet[lane] = if met { index as u64 } else { self.facet[lane] };
        }
    }
}

impl Default for Bundle {
    fn default() -> Self {
        Bundle::new()
    }
}

/// Eight lanes side by side, then those eight: an order that vectors can keep.
#[inline(always)]
fn fold(values: &Reals, choose: impl Fn(f64, f64) -> f64) -> f64 {
    let mut eight = [values[0]; 8];
    for chunk in values.chunks_exact(8) {
        for lane in 0..8 {
            eight[lane] = choose(eight[lane], chunk[lane]);
        }
    }
    eight.into_iter().fold(eight[0], choose)
}

impl Bounds {
    /// The greatest distance of an origin from the centre, or more.
    pub fn farthest(&self) -> f64 {
        let axis = |axis: usize| self.low[axis].abs().max(self.high[axis].abs());
        axis(0) + axis(1) + axis(2)
    }

    /// A lower bound on the distance at which a ray of the bundle is in the box from `low` to `high`, if one can be
    /// within `limit`.
    #[inline(always)]
    pub fn reach(&self, low: [f64; 3], high: [f64; 3], limit: f64) -> Option<f64> {
        let (mut from, mut to) = (0.0f64, limit);
        for axis in 0..3 {
            if self.slowest[axis] > LEVEL {
                let enter = low[axis] - self.high[axis];
                let leave = high[axis] - self.low[axis];
                if leave < 0.0 {
                    return None;
                }
                from = from.max(enter * self.inverse[axis][1]);
                to = to.min(leave * self.inverse[axis][0]);
            } else if self.fastest[axis] < -LEVEL {
                let enter = self.low[axis] - high[axis];
                let leave = self.high[axis] - low[axis];
                if leave < 0.0 {
                    return None;
                }
                from = from.max(enter * -self.inverse[axis][0]);
                to = to.min(leave * -self.inverse[axis][1]);
            }
        }
        if from > to {
            return None;
        }
        for axis in 0..3 {
            if self.slowest[axis] <= LEVEL && self.fastest[axis] >= -LEVEL {
                // At each distance the least position is at one end of the interval, for it is linear.
                let slowest = self.slowest[axis];
                let fastest = self.fastest[axis];
                let least = self.low[axis] + (slowest * from).min(slowest * to);
                let most = self.high[axis] + (fastest * from).max(fastest * to);
                if least > high[axis] || most < low[axis] {
                    return None;
                }
            }
        }
        Some(from)
    }
}
