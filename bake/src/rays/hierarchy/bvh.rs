//! Search for the nearest facet among many: a bounding volume hierarchy with eight boxes to a node.
//!
//! The tree only chooses the candidates: its boxes are padded by more than the error of an f32 ray,
//! and every candidate is tested in f64 by [`Triangle::meet`]. So the hit is the one that a loop
//! over all facets finds, bit for bit (tested).

use crate::optics::{Ray, Triangle};
use crate::rays::hierarchy::block::{Block, Sight};
use crate::rays::hierarchy::coherent::CoherentRays;
use crate::rays::hierarchy::frames::{MOST_FRAMES, frames};
use crate::rays::hierarchy::tree::{BLOCK, Boxes, Space, Wide, WideNode, build};
use crate::rays::simd::{InstructionSet, Task, fetch};
use glam::{DMat3, DVec3, Vec4};

/// Bounding volume hierarchy over a list of facets.
pub(crate) struct Hierarchy {
    nodes: Vec<WideNode>,
    blocks: Vec<Block>,
    /// Frames of the nodes, as maps from the cell frame.
    frames: Vec<DMat3>,
    instructions: InstructionSet,
    /// Largest number of nodes still to be looked at while a ray goes down.
    waiting: usize,
    centre: DVec3,
    /// Radius of a ball about `centre` that holds every facet, edge lengths.
    radius: f64,
    /// Padding of the boxes, edge lengths.
    padding: f64,
}

impl Hierarchy {
    /// Builds the hierarchy over `facets`, which are at least one.
    pub(crate) fn new(facets: &[Triangle]) -> Self {
        let corners = || facets.iter().flat_map(|facet| facet.corners);
        let low = corners().fold(DVec3::INFINITY, DVec3::min);
        let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        let centre = (low + high) / 2.0;
        let radius = corners()
            .map(|corner| corner.distance(centre))
            .fold(0.0, f64::max);
        // An f32 position within 2 radii of the centre is off by at most 2^-23 radii. At the far
        // side its ray is off by 2^-23 x 2 radii more, and the box test rounds three times. A
        // padding of 2^-19 radii is four times the sum.
        let padding = radius * (-19_f64).exp2();
        let frames = frames(facets);
        let space = Space {
            facets,
            centre,
            padding,
            frames: &frames,
        };
        let Wide {
            nodes,
            blocks,
            waiting,
        } = build(&space);
        Hierarchy {
            nodes,
            blocks,
            frames,
            instructions: InstructionSet::best(),
            waiting,
            centre,
            radius,
            padding,
        }
    }

    /// Returns the nearest of `facets` along `ray`, up to `limit` edge lengths away.
    ///
    /// `facets` are those that the hierarchy was built over.
    pub(crate) fn nearest(&self, facets: &[Triangle], ray: &Ray, limit: f64) -> Nearest {
        let (mut few, mut many) = ([(0.0, 0); FEW], Vec::new());
        let waiting = if self.waiting <= FEW {
            &mut few[..]
        } else {
            many.resize(self.waiting, (0.0, 0));
            &mut many[..]
        };
        self.instructions.run(Descent {
            hierarchy: self,
            facets,
            ray,
            limit,
            waiting,
        })
    }

    /// Returns the nearest facet as [`Hierarchy::nearest`] does.
    ///
    /// `waiting` is room for the nodes still to be looked at: a lower bound on their distance, and
    /// their number.
    #[inline(always)]
    fn descend(
        &self,
        facets: &[Triangle],
        ray: &Ray,
        limit: f64,
        waiting: &mut [(f32, u32)],
    ) -> Nearest {
        // The boxes are f32. If the ray starts far away, its way to the cell would use up the
        // digits, so for the boxes it starts near the cell.
        let origin = ray.origin - self.centre;
        let skipped = (-origin.dot(ray.direction) - 2.0 * self.radius).max(0.0);
        let origin = origin + ray.direction * skipped;
        let mut slabs = [Slabs::default(); MOST_FRAMES];
        for (slabs, frame) in slabs.iter_mut().zip(&self.frames) {
            *slabs = Slabs::new(*frame * origin, *frame * ray.direction);
        }
        let sight = Sight::new(ray, origin, self.radius);
        let far = |distance: f64| {
            let far = ((distance - skipped) * (1.0 + 1e-6) + self.padding) as f32;
            far.min(f32::MAX)
        };
        let mut nearest = Nearest::within(limit);
        let mut to = far(limit);
        let mut count = 1;
        waiting[0] = (0.0, 0);
        while count > 0 {
            count -= 1;
            let (from, at) = waiting[count];
            if from > to {
                continue;
            }
            if at & BLOCK != 0 {
                let block = &self.blocks[(at & !BLOCK) as usize];
                let mut seen = block.seen(&sight);
                while seen != 0 {
                    let facet = block.facets[seen.trailing_zeros() as usize] as usize;
                    seen &= seen - 1;
                    nearest.offer(facet, &facets[facet], ray);
                }
                to = far(nearest.distance);
                continue;
            }
            let node = &self.nodes[at as usize];
            let (entered, mut met) = slabs[node.frame as usize].reach(&node.boxes, to);
            let bottom = count;
            while met != 0 {
                let child = met.trailing_zeros() as usize;
                met &= met - 1;
                // The nearest is put last, because the last one is looked at first.
                let mut place = count;
                while place > bottom && waiting[place - 1].0 < entered[child] {
                    waiting[place] = waiting[place - 1];
                    place -= 1;
                }
                waiting[place] = (entered[child], node.children[child]);
                count += 1;
            }
        }
        nearest
    }

    /// Finds for all rays of `coherent` the nearest facet, as [`Hierarchy::nearest`] does without a
    /// limit.
    pub(crate) fn nearest_of_each(&self, facets: &[Triangle], coherent: &mut CoherentRays) {
        self.instructions.run(Common {
            hierarchy: self,
            facets,
            coherent,
        });
    }

    /// Finds the nearest facets as [`Hierarchy::nearest_of_each`] does.
    #[inline(always)]
    fn descend_together(&self, facets: &[Triangle], coherent: &mut CoherentRays) {
        let mut open = std::mem::take(&mut coherent.waiting);
        let ball = (self.centre, self.radius);
        coherent.look(ball, self.padding, &self.frames);
        let mut limit = coherent.limit();
        open.clear();
        let mut reached = coherent.all();
        let mut at = 0;
        loop {
            if at & BLOCK != 0 {
                let block = &self.blocks[(at & !BLOCK) as usize];
                coherent.offer(block, facets, reached, self.padding);
                limit = coherent.limit();
            } else {
                let node = &self.nodes[at as usize];
                let (from, mut met) = coherent.reach(node, limit);
                let bottom = open.len();
                while met != 0 {
                    let child = met.trailing_zeros() as usize;
                    met &= met - 1;
                    let from = from[child];
                    match node.children[child] {
                        block if block & BLOCK != 0 => {
                            fetch(&self.blocks[(block & !BLOCK) as usize]);
                        }
                        node => fetch(&self.nodes[node as usize]),
                    }
                    // The nearest is put last, because the last one is looked at first.
                    open.push((from, at << 3 | child as u32));
                    let mut place = open.len() - 1;
                    while place > bottom && open[place - 1].0 < from {
                        open.swap(place, place - 1);
                        place -= 1;
                    }
                }
            }
            reached = 0;
            while reached == 0 {
                let Some((from, place)) = open.pop() else {
                    coherent.waiting = open;
                    return;
                };
                if from <= limit {
                    let (node, child) = (&self.nodes[(place >> 3) as usize], place as usize & 7);
                    reached = coherent.entering(node, child);
                    at = node.children[child];
                }
            }
        }
    }
}

/// Search of coherent rays: the arguments of [`Hierarchy::descend_together`].
struct Common<'a> {
    hierarchy: &'a Hierarchy,
    facets: &'a [Triangle],
    coherent: &'a mut CoherentRays,
}

impl Task for Common<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.hierarchy.descend_together(self.facets, self.coherent);
    }
}

/// Search of one ray: the arguments of [`Hierarchy::descend`].
struct Descent<'a> {
    hierarchy: &'a Hierarchy,
    facets: &'a [Triangle],
    ray: &'a Ray,
    limit: f64,
    waiting: &'a mut [(f32, u32)],
}

impl Task for Descent<'_> {
    type Output = Nearest;

    #[inline(always)]
    fn run(self) -> Nearest {
        self.hierarchy
            .descend(self.facets, self.ray, self.limit, self.waiting)
    }
}

/// Components of a direction below this count as 0 with their sign.
///
/// Over the whole extent of the facets, the way along such an axis stays far below the padding of
/// their boxes.
const LEVEL: f64 = 1e-9;

/// Number that stands for 1 over 0.
const HUGE: f64 = 1e30;

/// Returns the inverse of a component of a direction, finite also for a component of 0.
#[inline(always)]
pub(crate) fn inverse(component: f64) -> f64 {
    if component.abs() < LEVEL {
        HUGE.copysign(component)
    } else {
        1.0 / component
    }
}

/// Number of waiting nodes for which a single ray needs no allocation.
///
/// All but the deepest trees need fewer: a tree of a million facets needs about 80.
const FEW: usize = 128;

/// Origin of a ray in a frame and the inverse of its direction, as the test of boxes needs them.
#[derive(Debug, Clone, Copy, Default)]
struct Slabs {
    origin: [f32; 3],
    inverse: [f32; 3],
    /// By axis: 0 if the ray comes to the lower end of a box first, 1 if to the upper one.
    near: [usize; 3],
}

impl Slabs {
    fn new(origin: DVec3, direction: DVec3) -> Self {
        let direction = direction.to_array();
        Slabs {
            origin: origin.as_vec3().to_array(),
            inverse: direction.map(|component| inverse(component) as f32),
            near: direction.map(|component| usize::from(component.is_sign_negative())),
        }
    }

    /// Returns the distance at which the ray enters each of eight boxes, and a set of bits.
    ///
    /// A bit is 1 if the ray enters the box within the distance `to`.
    #[inline(always)]
    fn reach(&self, boxes: &Boxes, to: f32) -> ([f32; 8], u32) {
        let (mut entered, mut met) = ([0.0; 8], 0);
        for half in [0, 4] {
            let four = |lanes: &[f32; 8]| Vec4::from_slice(&lanes[half..half + 4]);
            let (mut from, mut until) = (Vec4::ZERO, Vec4::splat(to));
            for axis in 0..3 {
                let (origin, inverse) = (self.origin[axis], self.inverse[axis]);
                let near = four(&boxes.ends[self.near[axis]][axis]);
                let far = four(&boxes.ends[1 - self.near[axis]][axis]);
                from = from.max((near - origin) * inverse);
                until = until.min((far - origin) * inverse);
            }
            met |= from.cmple(until).bitmask() << half;
            from.write_to_slice(&mut entered[half..]);
        }
        (entered, met)
    }
}

/// Nearest facet found so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nearest {
    /// Index of the facet; `None` if no facet is found yet.
    pub facet: Option<usize>,
    /// Distance of the facet, or the limit of the search, edge lengths.
    pub distance: f64,
    /// True if the ray meets the facet from the front.
    pub front: bool,
}

impl Nearest {
    /// Starts a search for facets up to `limit` edge lengths away.
    pub(crate) fn within(limit: f64) -> Self {
        Nearest {
            facet: None,
            distance: limit,
            front: false,
        }
    }

    /// Takes `facet` if `ray` meets it nearer than the nearest facet so far.
    ///
    /// Of two facets at one distance the lower index wins, so the result does not depend on the
    /// order of the offers.
    #[inline(always)]
    pub(crate) fn offer(&mut self, index: usize, facet: &Triangle, ray: &Ray) {
        if let Some(contact) = facet.meet(ray) {
            let tie =
                contact.distance == self.distance && self.facet.is_none_or(|known| index < known);
            if contact.distance < self.distance || tie {
                *self = Nearest {
                    facet: Some(index),
                    distance: contact.distance,
                    front: contact.front,
                };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two facets at one distance the lower index is met, in whichever order they are offered.
    #[test]
    fn of_two_facets_in_one_place_the_lower_number_is_met() {
        let facet = Triangle::new([DVec3::ZERO, DVec3::X, DVec3::Y]).expect("it has an area");
        let ray = Ray::new(DVec3::new(0.2, 0.2, 1.0), DVec3::NEG_Z, 1.0);
        for order in [[3, 7], [7, 3]] {
            let mut nearest = Nearest::within(f64::INFINITY);
            for index in order {
                nearest.offer(index, &facet, &ray);
            }
            assert_eq!((nearest.facet, nearest.distance), (Some(3), 1.0));
        }
    }

    /// Rays from ten million radii away meet what a loop over all facets says. Counted from there,
    /// a position in f32 would be off by half a radius. In f64 it is off by 1e-9 radii, for both
    /// alike, and the boxes are padded by more.
    #[test]
    fn rays_from_far_away_lose_no_digits() {
        let side = 12;
        let facets: Vec<Triangle> = (0..side * side)
            .filter_map(|k| {
                let low = DVec3::new(f64::from(k % side), f64::from(k / side), 0.0);
                let lift = 0.1 * f64::from(k % 5);
                Triangle::new([
                    low,
                    low + DVec3::new(0.9, 0.0, lift),
                    low + DVec3::new(0.0, 0.9, 0.0),
                ])
            })
            .collect();
        let tree = Hierarchy::new(&facets);
        let (mut cases, mut met) = (0, 0);
        for k in 0..400 {
            let target = DVec3::new(0.31 * f64::from(k % 40), 1.17 * f64::from(k / 40), 0.0);
            let direction = DVec3::new(0.1, -0.2, -1.0).normalize();
            let distance = 1e7 * tree.radius;
            let ray = Ray::new(target - distance * direction, direction, tree.radius);
            let mut slow = Nearest::within(f64::INFINITY);
            for (index, facet) in facets.iter().enumerate() {
                slow.offer(index, facet, &ray);
            }
            let fast = tree.nearest(&facets, &ray, f64::INFINITY);
            assert_eq!((fast.facet, fast.distance), (slow.facet, slow.distance));
            cases += 1;
            met += u32::from(slow.facet.is_some());
        }
        assert_eq!(cases, 400);
        assert!((100..300).contains(&met), "{met}");
    }
}
