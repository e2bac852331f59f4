//! Up to 64 parallel rays that go down the hierarchy together.
//!
//! Bounds on all rays of the bundle choose the boxes and facets to look at. Each such facet is then
//! tested against all rays side by side, first in f32 with a bound on the error. Where that does
//! not decide, the test makes the same operations in the same order as [`Aspect::meet`]. So every
//! ray finds the facet that it finds alone, bit for bit.

#![allow(
    clippy::needless_range_loop,
    reason = "the same lane of several arrays; iterators hide that"
)]

use crate::optics::{Aspect, Ray};
use crate::rays::lane::{LANES, Mask, Reals, Singles, fold, greater, lesser};
use glam::{DMat3, DVec3};

/// Number that stands for no facet.
pub(crate) const NONE: f64 = u32::MAX as f64;

/// Up to [`LANES`] rays of one direction, and the nearest facet found so far for each.
pub(crate) struct Bundle {
    /// Points where the rays start, by axis, edge lengths.
    pub origin: [Reals; 3],
    /// Bound on the error of each starting point, edge lengths; see [`crate::optics::Ray::slack`].
    pub slack: Reals,
    /// Nearest facet of each ray, now and before the last facet that was offered.
    ///
    /// They change places with every facet. In place, the compiler would store the changed lanes
    /// alone, which takes many processors dozens of cycles.
    met: [Met; 2],
    /// Place in `met` of the nearest facets now.
    now: usize,
    /// Nodes still to be looked at: a lower bound on their distance, and their number.
    pub waiting: Vec<(f64, u32)>,
    /// Bound on the rounding error of a triple product; see [`crate::optics::Ray::grain`].
    grain: f64,
    /// Number of vectors of 8 lanes that hold rays.
    vectors: usize,
    /// Centre of the smallest box that holds all origins.
    centre: DVec3,
    /// Half the size of that box.
    half: DVec3,
    /// Points where the rays start, counted from that centre, edge lengths.
    near: [Singles; 3],
    /// Greatest slack of a ray.
    most_slack: f64,
}

/// Nearest facet of each ray of a bundle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Met {
    /// Distance, edge lengths; infinite without a facet.
    pub distance: Reals,
    /// Number of the facet, or [`NONE`]: a whole number, as vectors compare it with distances.
    pub facet: Reals,
}

/// Bounds on the origins and the direction of all rays of a bundle.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Bounds {
    low: [f64; 3],
    high: [f64; 3],
    /// Inverse of each component of the direction.
    inverse: [f64; 3],
}

/// Components of a direction below this count as 0 with their sign.
///
/// Over the whole extent of the facets, the way along such an axis stays far below the padding of
/// their boxes.
const LEVEL: f64 = 1e-9;

/// Number that stands for 1 over 0.
const HUGE: f64 = 1e30;

impl Bundle {
    /// Makes a bundle without rays.
    pub(crate) fn new() -> Self {
        Bundle {
            origin: [[0.0; LANES]; 3],
            slack: [0.0; LANES],
            met: [Met {
                distance: [0.0; LANES],
                facet: [NONE; LANES],
            }; 2],
            now: 0,
            waiting: Vec::new(),
            grain: 0.0,
            vectors: 0,
            centre: DVec3::ZERO,
            half: DVec3::ZERO,
            near: [[0.0; LANES]; 3],
            most_slack: 0.0,
        }
    }

    /// Takes from one to [`LANES`] rays that start at `origin` (by axis) with `slack`.
    ///
    /// Lanes without a ray repeat the last ray.
    #[inline(always)]
    pub(crate) fn fill(&mut self, origin: [&[f64]; 3], slack: &[f64], grain: f64) {
        let count = slack.len();
        take(&mut self.origin[0], origin[0]);
        take(&mut self.origin[1], origin[1]);
        take(&mut self.origin[2], origin[2]);
        take(&mut self.slack, slack);
        self.grain = grain;
        self.vectors = count.div_ceil(8);
        let lanes = whole(self.vectors);
        // Lanes beyond these vectors find nothing, so they are never looked at.
        let met = &mut self.met[self.now];
        met.distance[..lanes].fill(f64::INFINITY);
        met.facet[..lanes].fill(NONE);
        let [x, y, z] = &self.origin;
        let low = DVec3::new(
            fold::<8, _>(x, lesser),
            fold::<8, _>(y, lesser),
            fold::<8, _>(z, lesser),
        );
        let high = DVec3::new(
            fold::<8, _>(x, greater),
            fold::<8, _>(y, greater),
            fold::<8, _>(z, greater),
        );
        self.centre = (low + high) / 2.0;
        // The last term makes up for the rounding of the centre.
        self.half = (high - low) / 2.0 + (low.abs() + high.abs()) * f64::EPSILON;
        for axis in 0..3 {
            let middle = self.centre[axis];
            for lane in 0..LANES {
                self.near[axis][lane] = (self.origin[axis][lane] - middle) as f32;
            }
        }
        self.most_slack = fold::<8, _>(&self.slack, greater);
    }

    /// Returns bounds on the rays, which travel along `direction`, in `frame`.
    ///
    /// Their origins are counted from `centre`. `frame` maps from the cell frame.
    #[inline(always)]
    pub(crate) fn bounds(&self, direction: DVec3, centre: DVec3, frame: &DMat3) -> Bounds {
        let direction = *frame * direction;
        let mut bounds = Bounds {
            low: [0.0; 3],
            high: [0.0; 3],
            inverse: direction.to_array().map(inverse),
        };
        let [x, y, z] = &self.near;
        // In f32 a sum of three products of numbers up to the half size is off by less than 8 times
        // 2^-24 of their sum. Here are 16.
        let rounding = (-20_f64).exp2() * self.half.element_sum();
        for axis in 0..3 {
            let along = frame.row(axis);
            let [a, b, c] = along.as_vec3().to_array();
            let (mut low, mut high) = ([f32::MAX; 8], [f32::MIN; 8]);
            for first in (0..whole(self.vectors)).step_by(8) {
                for lane in 0..8 {
                    let at = x[first + lane] * a + y[first + lane] * b + z[first + lane] * c;
                    low[lane] = lesser(at, low[lane]);
                    high[lane] = greater(at, high[lane]);
                }
            }
            let middle = (self.centre - centre).dot(along);
            let [low, high] = [
                low.into_iter().fold(f32::MAX, lesser),
                high.into_iter().fold(f32::MIN, greater),
            ];
            bounds.low[axis] = middle + f64::from(low) - rounding;
            bounds.high[axis] = middle + f64::from(high) + rounding;
        }
        bounds
    }

    /// Returns a ray along `direction` from the middle of all origins, with bounds on the errors of
    /// all rays, and how far by axis other origins are from it at most, edge lengths.
    #[inline(always)]
    pub(crate) fn middle(&self, direction: DVec3) -> (Ray, DVec3) {
        let middle = Ray {
            origin: self.centre,
            direction,
            slack: self.most_slack,
            grain: self.grain,
        };
        (middle, self.half)
    }

    /// Returns the distance beyond which no ray of the bundle looks for facets.
    #[inline(always)]
    pub(crate) fn limit(&self) -> f64 {
        fold::<8, _>(&self.met().distance[..whole(self.vectors)], greater)
    }

    /// Returns the nearest facet found so far for each ray.
    #[inline(always)]
    pub(crate) fn met(&self) -> &Met {
        &self.met[self.now]
    }

    /// Returns the edges of the facet that rays may pass on either side, and their number. All rays
    /// pass inside of the others.
    ///
    /// Returns `None` if no ray can meet the facet, because all rays pass beyond one of its edges
    /// or start behind it.
    #[inline(always)]
    fn open_edges(&self, aspect: &Aspect) -> Option<([Edge; 3], usize)> {
        let mut edges = [Edge::default(); 3];
        let mut open = 0;
        // A function that is linear in the origin is off its value at the centre by `spread` at
        // most. The margin is twice that of the test of a ray, and so covers the rounding of both.
        let height = (self.centre - aspect.corners[0]).dot(aspect.normal) * aspect.side;
        if height + self.half.dot(aspect.normal.abs()) < -2.0 * self.most_slack {
            return None;
        }
        for number in 0..3 {
            let inward = aspect.inward[number];
            let value = (self.centre - aspect.corners[number]).dot(inward);
            let spread = self.half.dot(inward.abs());
            let margin = 2.0 * (self.most_slack * aspect.lengths[number] + self.grain);
            if value + spread < -margin {
                return None;
            }
            if value - spread > margin {
                continue;
            }
            edges[open] = Edge {
                number,
                value,
                spread,
                margin,
            };
            open += 1;
        }
        Some((edges, open))
    }

    /// Returns the rays that pass inside of all `edges`, or `None` if there is no such ray.
    ///
    /// The test is in f32. Rays too near an edge for it go through the test in f64, all together.
    #[inline(always)]
    fn inside(&self, edges: &[Edge], aspect: &Aspect) -> Option<Mask> {
        let vectors = self.vectors;
        let (surely, maybe) = match *edges {
            [] => return Some([1; LANES]),
            [first] => self.bounds_inside([first], aspect),
            [first, second] => self.bounds_inside([first, second], aspect),
            [first, second, third, ..] => self.bounds_inside([first, second, third], aspect),
        };
        let (mut on, mut any, mut unsure): (Mask, u32, u64) = ([0; LANES], 0, 0);
        for lane in 0..whole(vectors) {
            any |= u32::from(maybe[lane] >= 0.0);
        }
        if any == 0 {
            return None;
        }
        for lane in 0..whole(vectors) {
            on[lane] = u64::from(surely[lane] > 0.0);
            unsure |= on[lane] ^ u64::from(maybe[lane] >= 0.0);
        }
        if unsure == 0 {
            return Some(on);
        }
        on = [1; LANES];
        for edge in edges.iter().map(|edge| edge.number) {
            let corner = aspect.corners[edge];
            let value = over(&self.origin, vectors, corner, aspect.inward[edge]);
            let length = aspect.lengths[edge];
            for lane in 0..whole(vectors) {
                let margin = -(aspect.side * (self.slack[lane] * length + self.grain));
                on[lane] &= u64::from(value[lane] >= margin);
            }
        }
        (!none(&on, vectors)).then_some(on)
    }

    /// Returns a lower and an upper bound on the least of the rays' triple products with `edges`.
    #[inline(always)]
    fn bounds_inside<const N: usize>(
        &self,
        edges: [Edge; N],
        aspect: &Aspect,
    ) -> (Singles, Singles) {
        let inward = edges.map(|edge| aspect.inward[edge.number].as_vec3());
        let values = edges.map(|edge| edge.value as f32);
        let errors = edges.map(|edge| edge.error());
        let [x, y, z] = &self.near;
        let (mut surely, mut maybe) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..whole(self.vectors) {
            let (mut low, mut high) = (f32::MAX, f32::MAX);
            for edge in 0..N {
                let along = inward[edge];
                let at = x[lane] * along.x + y[lane] * along.y + z[lane] * along.z + values[edge];
                low = lesser(at - errors[edge], low);
                high = lesser(at + errors[edge], high);
            }
            (surely[lane], maybe[lane]) = (low, high);
        }
        (surely, maybe)
    }

    /// Takes the facet for every ray that meets it nearer than its nearest facet so far.
    ///
    /// Returns whether any ray may have met the facet. Each ray gets the result of
    /// [`crate::rays::nearest::Nearest::offer`].
    #[inline(always)]
    pub(crate) fn offer(&mut self, index: usize, aspect: &Aspect) -> bool {
        let Some((edges, open)) = self.open_edges(aspect) else {
            return false;
        };
        let Some(on) = self.inside(&edges[..open], aspect) else {
            return false;
        };
        let (side, vectors) = (aspect.side, self.vectors);
        let height = over(&self.origin, vectors, aspect.corners[0], aspect.normal);
        let [even, odd] = &mut self.met;
        let (known, next) = if self.now == 0 {
            (&*even, odd)
        } else {
            (&*odd, even)
        };
        let index = index as f64;
        for lane in 0..whole(vectors) {
            let ahead = side * height[lane] >= -(side * self.slack[lane]);
            let quotient = -height[lane] / aspect.cosine;
            let distance = if quotient > 0.0 { quotient } else { 0.0 };
            let (least, number) = (known.distance[lane], known.facet[lane]);
            let nearer = (distance < least) | ((distance == least) & (index < number));
            let met = (on[lane] != 0) & ahead & nearer;
            next.distance[lane] = if met { distance } else { least };
            next.facet[lane] = if met { index } else { number };
        }
        self.now = 1 - self.now;
        true
    }
}

/// Edge of a facet as the rays of a bundle pass it.
///
/// A ray passes inside if its triple product with the edge is not negative.
#[derive(Debug, Clone, Copy, Default)]
struct Edge {
    /// Number of the edge.
    number: usize,
    /// Triple product of the centre of the bundle, square edge lengths.
    value: f64,
    /// Greatest difference from it of a ray's.
    spread: f64,
    /// Twice the greatest margin of the exact test.
    margin: f64,
}

impl Edge {
    /// Returns the value within which the test in f32 does not decide.
    ///
    /// In f32 each of six factors, three products and three sums is off by a part of 2^-24. A way
    /// from the centre times the gradient is at most the spread. So the sum is off by less than 8
    /// times 2^-24 of value and spread, and the bounds by as much again. Here are 16.
    #[inline(always)]
    fn error(&self) -> f32 {
        let rounding = (-20_f64).exp2() * (self.value.abs() + self.spread);
        ((rounding + self.margin) * (1.0 + 1e-6)) as f32
    }
}

/// Returns the number of lanes in so many vectors.
///
/// The form of the result tells the compiler that it is a multiple of 8 and at most [`LANES`].
#[inline(always)]
fn whole(vectors: usize) -> usize {
    vectors.min(LANES / 8) * 8
}

/// Returns the height of each origin over the plane through `corner`, times the length of
/// `gradient`.
///
/// The terms are added in the order of glam's dot product.
#[inline(always)]
fn over(origin: &[Reals; 3], vectors: usize, corner: DVec3, gradient: DVec3) -> Reals {
    let [x, y, z] = origin;
    let mut value = [0.0; LANES];
    for lane in 0..whole(vectors) {
        value[lane] = (x[lane] - corner.x) * gradient.x
            + (y[lane] - corner.y) * gradient.y
            + (z[lane] - corner.z) * gradient.z;
    }
    value
}

/// Returns whether no lane of `mask` is set.
#[inline(always)]
fn none(mask: &Mask, vectors: usize) -> bool {
    let mut any = 0;
    for lane in 0..whole(vectors) {
        any |= mask[lane];
    }
    any == 0
}

impl Default for Bundle {
    fn default() -> Self {
        Bundle::new()
    }
}

/// Fills the lanes with the values, and the remaining lanes with the last value.
#[inline(always)]
fn take(lanes: &mut Reals, values: &[f64]) {
    let (taken, left) = lanes.split_at_mut(values.len());
    taken.copy_from_slice(values);
    left.fill(values[values.len() - 1]);
}

/// Returns the inverse of a component of a direction, finite also for a component of 0.
#[inline(always)]
pub(crate) fn inverse(component: f64) -> f64 {
    if component.abs() < LEVEL {
        HUGE.copysign(component)
    } else {
        1.0 / component
    }
}

impl Bounds {
    /// Returns an upper bound on the distance of any origin from the centre, edge lengths.
    pub(crate) fn farthest(&self) -> f64 {
        let axis = |axis: usize| self.low[axis].abs().max(self.high[axis].abs());
        axis(0) + axis(1) + axis(2)
    }

    /// Returns a lower bound, for each of eight boxes, on the distance at which a ray is in the
    /// box.
    ///
    /// The bound is infinite if no ray of the bundle can be in the box within the distance `limit`.
    #[inline(always)]
    pub(crate) fn reach(&self, boxes: &Boxes, limit: f64) -> [f64; 8] {
        let (mut from, mut to) = ([0.0_f64; 8], [limit; 8]);
        for axis in 0..3 {
            let (low, high) = (self.low[axis], self.high[axis]);
            let inverse = self.inverse[axis];
            for i in 0..8 {
                let one = (f64::from(boxes.ends[0][axis][i]) - high) * inverse;
                let other = (f64::from(boxes.ends[1][axis][i]) - low) * inverse;
                from[i] = greater(lesser(one, other), from[i]);
                to[i] = lesser(greater(one, other), to[i]);
            }
        }
        for i in 0..8 {
            from[i] = if from[i] <= to[i] {
                from[i]
            } else {
                f64::INFINITY
            };
        }
        from
    }
}

/// Eight boxes side by side, by axis; an empty place holds a point at infinity.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Boxes {
    /// Ends of the boxes: lower and upper, by axis.
    pub ends: [[[f32; 8]; 3]; 2],
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the bound against the corners of boxes: no corner may lie beyond it. All numbers are
    /// exact in binary. The last box is reached along the third axis alone.
    #[test]
    fn no_origin_lies_beyond_the_farthest() {
        let boxes = [
            ([-1.0, -0.5, 2.0], [0.5, 3.0, 4.0]),
            ([-8.0, 0.25, -1.0], [-2.0, 0.5, 0.5]),
            ([0.0, 0.0, -4.0], [0.0, 0.0, 2.0]),
        ];
        let mut cases = 0;
        for (low, high) in boxes {
            let bounds = Bounds {
                low,
                high,
                inverse: [1.0; 3],
            };
            for corner in 0..8 {
                let at = |axis: usize| [low, high][corner >> axis & 1][axis];
                let distance = at(0).hypot(at(1)).hypot(at(2));
                assert!(distance <= bounds.farthest(), "{corner}: {distance}");
                cases += 1;
            }
        }
        assert_eq!(cases, 24);
    }

    /// Origins close together and far apart, near the centre and far from it: none lies outside of
    /// the bounds, in any frame. The bounds are no wider than their rounding in f32.
    #[test]
    fn origins_lie_within_the_bounds() {
        let mut cases = 0;
        for turn in 0..200_u32 {
            let t = f64::from(turn);
            let size = [1.0, 1e-3, 1e-9, 0.0][turn as usize % 4];
            let middle = DVec3::new((1.1 * t).sin(), (2.3 * t).cos(), (0.7 * t).sin()) * 50.0;
            let at = |k: usize, way: f64| middle.x + size * (way * k as f64).sin();
            let origins =
                [1.3, 2.9, 7.1].map(|way| (0..60).map(|k| at(k, way)).collect::<Vec<_>>());
            let mut bundle = Bundle::new();
            bundle.fill([&origins[0], &origins[1], &origins[2]], &[1e-15; 60], 1e-15);
            let frame = DMat3::from_axis_angle(middle.normalize(), t);
            let bounds = bundle.bounds(DVec3::NEG_Z, middle, &frame);
            for k in 0..60 {
                let origin = DVec3::new(origins[0][k], origins[1][k], origins[2][k]);
                let own = (frame * (origin - middle)).to_array();
                // The expected value is itself rounded at coordinates up to 100.
                let rounding = 200.0 * f64::EPSILON;
                for axis in 0..3 {
                    assert!(
                        own[axis] >= bounds.low[axis] - rounding,
                        "{turn} {k} {axis}"
                    );
                    assert!(
                        own[axis] <= bounds.high[axis] + rounding,
                        "{turn} {k} {axis}"
                    );
                    cases += 1;
                }
            }
            for axis in 0..3 {
                let width = bounds.high[axis] - bounds.low[axis];
                assert!(width <= 4.0 * size + 1e-12, "{turn}: {width}");
            }
        }
        assert_eq!(cases, 200 * 60 * 3);
    }

    /// Two facets lie in one place. Whichever is offered first, all rays take the lower number.
    #[test]
    fn of_two_facets_in_one_place_the_lower_number_is_met() {
        let corners = [
            DVec3::new(-1.0, -1.0, 0.0),
            DVec3::new(3.0, -1.0, 0.0),
            DVec3::new(-1.0, 3.0, 0.0),
        ];
        let facet = crate::optics::Triangle::new(corners).expect("it spans a plane");
        let aspect = facet.along(DVec3::NEG_Z).expect("it is met from the front");
        for order in [[4, 7], [7, 4]] {
            let mut bundle = Bundle::new();
            let (x, y, z) = ([0.0, 0.25, 0.5], [0.5, 0.25, 0.0], [1.0, 2.0, 3.0]);
            bundle.fill([&x, &y, &z], &[1e-15; 3], 1e-15);
            for index in order {
                assert!(bundle.offer(index, &aspect));
            }
            assert_eq!(bundle.met().facet[..3], [4.0; 3], "{order:?}");
            assert_eq!(bundle.met().distance[..3], z);
        }
    }

    /// Bundles whose rays are aimed at points 1e-18 to 1e-3 edge lengths from an edge, on either
    /// side, with origins that lie close together or far apart: every ray finds what
    /// [`crate::rays::nearest::Nearest`] finds for it alone.
    #[test]
    fn rays_beside_an_edge_find_what_they_find_alone() {
        let corners = [
            DVec3::new(0.1, 0.2, -0.3),
            DVec3::new(1.3, 0.1, 0.4),
            DVec3::new(0.3, 0.9, 0.2),
        ];
        let facet = crate::optics::Triangle::new(corners).expect("has area");
        let (mut cases, mut met) = (0, 0);
        for turn in 0..400_u32 {
            let t = f64::from(turn);
            let away = DVec3::new((1.1 * t).sin(), (2.3 * t).cos(), (0.7 * t).sin()).normalize();
            let Some(aspect) = facet.along(-away) else {
                continue;
            };
            let edge = turn as usize % 3;
            let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
            let inward = facet.normal.cross(b - a).normalize();
            let along = [1e-9, 1e-3, 1.0][turn as usize / 3 % 3];
            let rays: Vec<Ray> = (0..LANES - turn as usize % 5)
                .map(|k| {
                    let share = 0.5 + along * ((k as f64 * 0.618_034).fract() - 0.5);
                    let off = 10_f64.powi(k as i32 % 16 - 18) * f64::from(k as i32 % 3 - 1);
                    let target = a.lerp(b, share) + inward * off;
                    Ray::new(target + away * 1.5, -away, 4.0)
                })
                .collect();
            let axis = |axis: usize| rays.iter().map(|ray| ray.origin[axis]).collect::<Vec<_>>();
            let slack: Vec<f64> = rays.iter().map(|ray| ray.slack).collect();
            let mut bundle = Bundle::new();
            bundle.fill([&axis(0), &axis(1), &axis(2)], &slack, rays[0].grain);
            bundle.offer(7, &aspect);
            for (lane, ray) in rays.iter().enumerate() {
                let alone = aspect.meet(ray);
                let found =
                    (bundle.met().facet[lane] == 7.0).then_some(bundle.met().distance[lane]);
                assert_eq!(found, alone, "{turn} {lane}");
                cases += 1;
                met += u32::from(alone.is_some());
            }
        }
        println!("{met} of {cases} rays meet the facet");
        assert!(
            cases > 20_000 && met > cases / 4 && met < cases,
            "{met} of {cases}"
        );
    }
}
