//! Up to 64 rays of nearly one direction that go down the hierarchy together.
//!
//! Bounds on all rays choose the boxes to look at, eight at once. Then each box is tested against
//! all rays side by side, and the rays that enter it go on. So a ray looks at the facets that it
//! looks at alone, and finds the same one, bit for bit.

#![allow(
    clippy::needless_range_loop,
    reason = "the same lane of several arrays; iterators hide that"
)]

use crate::optics::{Ray, Triangle};
use crate::rays::hierarchy::block::{Block, Sight};
use crate::rays::hierarchy::bvh::Nearest;
use crate::rays::hierarchy::bvh::inverse;
use crate::rays::hierarchy::frames::MOST_FRAMES;
use crate::rays::hierarchy::tree::{Boxes, WideNode};
use crate::rays::lane::{LANES, Singles, fold, greater, lesser};
use crate::rays::simd::fetch;
use glam::{DMat3, DVec3};

/// Up to [`LANES`] rays, and the nearest facet of each.
pub(crate) struct CoherentRays {
    rays: Vec<Ray>,
    /// Nearest facet of each ray.
    pub nearest: Vec<Nearest>,
    /// Nodes still to be looked at: a lower bound on their distance, and their place: eight times
    /// the number of the node above, plus the number of the child.
    pub waiting: Vec<(f32, u32)>,
    /// Rays in the frames of the hierarchy.
    lines: [FrameLines; MOST_FRAMES],
    sights: Vec<Sight>,
    /// Numbers of rays with those of facets of a block that they may meet.
    candidates: Vec<(u32, u32)>,
    /// Way from the start of each ray to the point from which boxes see it, edge lengths.
    skipped: Vec<f64>,
    /// Distance from this point up to which each ray looks for facets, edge lengths.
    to: Singles,
}

/// Origins and inverse directions of rays in a frame, with bounds on all of them.
struct FrameLines {
    origin: [Singles; 3],
    inverse: [Singles; 3],
    /// Least and greatest origin by axis.
    origins: [[f32; 2]; 3],
    /// Least and greatest inverse by axis.
    inverses: [[f32; 2]; 3],
    /// End of a box, 0 or 1 by axis, through which all rays go in; `None` if they differ.
    first: Option<[usize; 3]>,
}

impl CoherentRays {
    /// Makes an empty set of rays.
    pub(crate) fn new() -> Self {
        let lines = || FrameLines {
            origin: [[0.0; LANES]; 3],
            inverse: [[1.0; LANES]; 3],
            origins: [[0.0; 2]; 3],
            inverses: [[1.0; 2]; 3],
            first: None,
        };
        CoherentRays {
            rays: Vec::new(),
            nearest: Vec::new(),
            waiting: Vec::new(),
            lines: std::array::from_fn(|_| lines()),
            sights: Vec::new(),
            candidates: Vec::new(),
            skipped: Vec::new(),
            to: [BESIDE; LANES],
        }
    }

    /// Takes from one to [`LANES`] rays in place of those before.
    pub(crate) fn fill(&mut self, rays: impl Iterator<Item = Ray>) {
        self.rays.clear();
        self.rays.extend(rays.take(LANES));
    }

    /// Returns the set of all rays, one bit for each.
    #[inline(always)]
    pub(crate) fn all(&self) -> u64 {
        u64::MAX >> (LANES - self.rays.len())
    }

    /// Looks at the facets in a ball, given by centre and radius, in `frames`.
    ///
    /// `padding` is that of the boxes, edge lengths.
    #[inline(always)]
    pub(crate) fn look(&mut self, (centre, radius): (DVec3, f64), padding: f64, frames: &[DMat3]) {
        self.nearest.clear();
        self.sights.clear();
        self.skipped.clear();
        self.to = [BESIDE; LANES];
        for (lane, ray) in self.rays.iter().enumerate() {
            // The boxes are f32. If the ray starts far away, its way to the cell would use up the
            // digits, so for the boxes it starts near the cell.
            let origin = ray.origin - centre;
            let skipped = (-origin.dot(ray.direction) - 2.0 * radius).max(0.0);
            let origin = origin + ray.direction * skipped;
            for (lines, frame) in self.lines.iter_mut().zip(frames) {
                lines.set(lane, *frame * origin, *frame * ray.direction);
            }
            self.sights.push(Sight::new(ray, origin, radius));
            self.skipped.push(skipped);
            let nearest = Nearest::within(f64::INFINITY);
            self.to[lane] = far(nearest.distance, skipped, padding);
            self.nearest.push(nearest);
        }
        for lines in &mut self.lines[..frames.len()] {
            lines.repeat(self.rays.len());
            lines.bound();
        }
    }

    /// Returns the distance beyond which no ray looks for facets.
    #[inline(always)]
    pub(crate) fn limit(&self) -> f32 {
        fold::<16, _>(&self.to, greater)
    }

    /// Returns a lower bound on the distance at which a ray enters each box of `node`, and the set
    /// of boxes that a ray may enter within the distance `limit`.
    #[inline(always)]
    pub(crate) fn reach(&self, node: &WideNode, limit: f32) -> ([f32; 8], u32) {
        let (from, met) = self.lines[node.frame as usize].reach(&node.boxes, limit);
        (from, met & node.used)
    }

    /// Returns the rays that enter the box of child number `child` of `node`, one bit for each.
    #[inline(always)]
    pub(crate) fn entering(&self, node: &WideNode, child: usize) -> u64 {
        let bounds = |end: usize| [0, 1, 2].map(|axis| node.boxes.ends[end][axis][child]);
        self.lines[node.frame as usize].entering([bounds(0), bounds(1)], &self.to)
    }

    /// Offers the facets of `block` to those of the rays that are in `reached`.
    #[inline(always)]
    pub(crate) fn offer(
        &mut self,
        block: &Block,
        facets: &[Triangle],
        mut reached: u64,
        padding: f64,
    ) {
        self.candidates.clear();
        while reached != 0 {
            let lane = reached.trailing_zeros() as usize;
            reached &= reached - 1;
            let mut seen = block.seen(&self.sights[lane]);
            while seen != 0 {
                let facet = block.facets[seen.trailing_zeros() as usize];
                seen &= seen - 1;
                fetch(&facets[facet as usize]);
                self.candidates.push((lane as u32, facet));
            }
        }
        for &(lane, facet) in &self.candidates {
            let (lane, facet) = (lane as usize, facet as usize);
            let nearest = &mut self.nearest[lane];
            nearest.offer(facet, &facets[facet], &self.rays[lane]);
            self.to[lane] = far(nearest.distance, self.skipped[lane], padding);
        }
    }
}

/// Distance up to which a lane without a ray looks for facets.
const BESIDE: f32 = -1.0;

/// Returns the distance up to which a ray looks for facets if it has found one at `distance`.
#[inline(always)]
fn far(distance: f64, skipped: f64, padding: f64) -> f32 {
    let far = ((distance - skipped) * (1.0 + 1e-6) + padding) as f32;
    far.min(f32::MAX)
}

impl FrameLines {
    /// Takes the ray of a lane.
    #[inline(always)]
    fn set(&mut self, lane: usize, origin: DVec3, direction: DVec3) {
        for axis in 0..3 {
            self.origin[axis][lane] = origin[axis] as f32;
            self.inverse[axis][lane] = inverse(direction[axis]) as f32;
        }
    }

    /// Fills the lanes beyond the first `count` with the first ray.
    #[inline(always)]
    fn repeat(&mut self, count: usize) {
        for lanes in self.origin.iter_mut().chain(&mut self.inverse) {
            let first = lanes[0];
            lanes[count..].fill(first);
        }
    }

    /// Bounds all lanes.
    #[inline(always)]
    fn bound(&mut self) {
        let ends = |lanes: &Singles| [fold::<16, _>(lanes, lesser), fold::<16, _>(lanes, greater)];
        for axis in 0..3 {
            self.origins[axis] = ends(&self.origin[axis]);
            let [low, high] = ends(&self.inverse[axis]);
            // Between a negative and a positive inverse lies the infinite one.
            self.inverses[axis] = match low < 0.0 && high > 0.0 {
                true => [-MOST, MOST],
                false => [low, high],
            };
        }
        let same = |[low, high]: &[f32; 2]| (*low >= 0.0) | (*high <= 0.0);
        self.first = self
            .inverses
            .iter()
            .all(same)
            .then(|| self.inverses.map(|[_, high]| usize::from(high <= 0.0)));
    }

    /// Returns what [`CoherentRays::reach`] does.
    ///
    /// Differences and products of f32 are monotonic also after rounding. So the bounds hold for
    /// what each ray computes in [`FrameLines::entering`].
    #[inline(always)]
    fn reach(&self, boxes: &Boxes, limit: f32) -> ([f32; 8], u32) {
        let (mut from, mut to) = ([0.0; 8], [limit; 8]);
        if let Some(first) = self.first {
            for axis in 0..3 {
                let end = first[axis];
                let (origins, [low, high]) = (self.origins[axis], self.inverses[axis]);
                let (near, far) = (&boxes.ends[end][axis], &boxes.ends[1 - end][axis]);
                for i in 0..8 {
                    let (one, other) = (near[i] - origins[1 - end], far[i] - origins[end]);
                    from[i] = greater(lesser(one * low, one * high), from[i]);
                    to[i] = lesser(greater(other * low, other * high), to[i]);
                }
            }
            return (from, met(&from, &to));
        }
        for axis in 0..3 {
            let ([least, greatest], [low, high]) = (self.origins[axis], self.inverses[axis]);
            for i in 0..8 {
                let one = boxes.ends[0][axis][i] - greatest;
                let other = boxes.ends[1][axis][i] - least;
                let (a, b, c, d) = (one * low, one * high, other * low, other * high);
                from[i] = greater(lesser(lesser(a, b), lesser(c, d)), from[i]);
                to[i] = lesser(greater(greater(a, b), greater(c, d)), to[i]);
            }
        }
        (from, met(&from, &to))
    }

    /// Returns the set of rays that enter the box between `ends` within the distances `to`.
    #[inline(always)]
    fn entering(&self, ends: [[f32; 3]; 2], to: &Singles) -> u64 {
        let (mut from, mut until) = ([0.0; LANES], *to);
        for axis in 0..3 {
            let (origin, inverse) = (&self.origin[axis], &self.inverse[axis]);
            if let Some(first) = self.first {
                let end = first[axis];
                let (near, far) = (ends[end][axis], ends[1 - end][axis]);
                for lane in 0..LANES {
                    from[lane] = greater((near - origin[lane]) * inverse[lane], from[lane]);
                    until[lane] = lesser((far - origin[lane]) * inverse[lane], until[lane]);
                }
                continue;
            }
            let (low, high) = (ends[0][axis], ends[1][axis]);
            for lane in 0..LANES {
                let one = (low - origin[lane]) * inverse[lane];
                let other = (high - origin[lane]) * inverse[lane];
                from[lane] = greater(lesser(one, other), from[lane]);
                until[lane] = lesser(greater(one, other), until[lane]);
            }
        }
        let mut entering = 0;
        for lane in 0..LANES {
            entering |= u64::from(from[lane] <= until[lane]) << lane;
        }
        entering
    }
}

/// Returns the set of eight boxes that are left no earlier than they are entered.
#[inline(always)]
fn met(from: &[f32; 8], to: &[f32; 8]) -> u32 {
    let mut met = 0;
    for i in 0..8 {
        met |= u32::from(from[i] <= to[i]) << i;
    }
    met
}

/// Bound on the inverse of a component of a direction.
const MOST: f32 = 1e30;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::hierarchy::bvh::Hierarchy;

    /// Rays of all directions, alike ones and single ones, from outside and from facets: each finds
    /// what a loop over all facets finds.
    #[test]
    fn every_ray_finds_what_a_loop_finds() {
        let spread = |k: u32| f64::from(k.wrapping_mul(2_654_435_769)) / 2_147_483_648.0 - 1.0;
        let point = |k: u32| DVec3::new(spread(3 * k), spread(3 * k + 1), spread(3 * k + 2));
        let facets: Vec<Triangle> = (0..500)
            .filter_map(|k| {
                let low = point(4 * k);
                Triangle::new([
                    low,
                    low + point(4 * k + 1) * 0.2,
                    low + point(4 * k + 2) * 0.2,
                ])
            })
            .collect();
        let tree = Hierarchy::new(&facets);
        let mut coherent = CoherentRays::new();
        let (mut cases, mut met) = (0, 0);
        for k in 0..60 {
            let count = [64, 7, 1][k as usize % 3];
            // Directions within a tenth of each other, and directions all around.
            let width = if k % 2 == 0 { 0.1 } else { 2.0 };
            let rays: Vec<Ray> = (0..count)
                .map(|i| {
                    let n = 5_000 + 64 * k + i;
                    let origin = match k % 4 {
                        0 => facets[n as usize % facets.len()].corners[0],
                        _ => point(n) * 2.0,
                    };
                    let way = point(9_000 + k) + point(n + 20_000) * width;
                    Ray::new(origin, way.normalize(), 4.0)
                })
                .collect();
            coherent.fill(rays.iter().copied());
            tree.nearest_of_each(&facets, &mut coherent);
            for (ray, found) in rays.iter().zip(&coherent.nearest) {
                let mut slow = Nearest::within(f64::INFINITY);
                for (index, facet) in facets.iter().enumerate() {
                    slow.offer(index, facet, ray);
                }
                assert_eq!(*found, slow, "{k}");
                cases += 1;
                met += u32::from(slow.facet.is_some());
            }
        }
        println!("{met} of {cases} rays meet a facet");
        assert_eq!(cases, 20 * (64 + 7 + 1));
        assert!(met > cases / 10 && met < cases, "{met}");
    }
}
