//! Many rays through a hierarchy at once, for meshes that no program fits (curved, or of many different cells).
//!
//! All rays of a direction travel alike, and those that then meet the same facet go on alike. A **packet** is the rays
//! of one [`Course`]: the same facets in the same order. It is cut into bundles of neighbours, each of which goes down
//! the hierarchy together; then the packet is grouped by the facets met, and each group goes on as a packet.

use crate::optics::ray::Direction;
use crate::optics::triangle::Facet;
use crate::rays::bundle::{Bundle, NONE};
use crate::rays::bvh::Hierarchy;
use crate::rays::lanes::LANES;
use crate::rays::path::{Course, Rules};
use crate::rays::scene::Scene;
use crate::rays::simd::InstructionSet;
use crate::rays::tally::{Bins, Tally};
use glam::{DVec2, DVec3};
use tables::Fate;
use tables::deviation::Grid;

/// Rays of one course: where they are, and what they meet next.
#[derive(Debug, Default)]
pub struct Packet {
    /// Where they entered.
    point: Vec<DVec2>,
    /// Where they are, by axis: first where they start, then where they have met a facet.
    position: [Vec<f64>; 3],
    slack: Vec<f64>,
    distance: Vec<f64>,
    /// Facet met, then number of the ray, in one number to sort by.
    met: Vec<u64>,
}

/// What the rays of a packet go through, and how.
pub struct Way<'a> {
    /// Hierarchy over the facets.
    pub hierarchy: &'a Hierarchy,
    /// What they can meet.
    pub facets: &'a [Facet],
    /// Direction of travel.
    pub direction: DVec3,
    /// As [`crate::optics::ray::Ray::grain`].
    pub grain: f64,
    /// The facet that they come from: it is plane and they leave to its front, so they do not meet it.
    pub from: Option<usize>,
}

/// No facet, in [`Packet::met`].
const OUT: u64 = NONE >> 32;

impl Packet {
    fn clear(&mut self) {
        self.point.clear();
        self.position.iter_mut().for_each(Vec::clear);
        self.slack.clear();
        self.distance.clear();
        self.met.clear();
    }

    fn push(&mut self, point: DVec2, position: DVec3, slack: f64) {
        let [x, y, z] = &mut self.position;
        self.point.push(point);
        x.push(position.x);
        y.push(position.y);
        z.push(position.z);
        self.slack.push(slack);
    }

    fn position(&self, which: usize) -> DVec3 {
        let [x, y, z] = &self.position;
        DVec3::new(x[which], y[which], z[which])
    }

    /// Puts rays that have met the same facet, of so many, after each other.
    fn group(&mut self, facets: usize) {
        if self.met.len() < facets {
            self.met.sort_unstable();
        } else {
            let order = order(&self.met, facets + 1, |met| {
                (met >> 32).min(facets as u64) as usize
            });
            self.met = order;
        }
    }

    /// Takes every ray to the nearest facet.
    #[inline(always)]
    pub fn advance(&mut self, way: &Way, bundle: &mut Bundle) {
        let count = self.slack.len();
        self.distance.reserve(count);
        self.met.reserve(count);
        for first in (0..count).step_by(LANES) {
            let lanes = first..count.min(first + LANES);
            let [x, y, z] = &self.position;
            let origin = [&x[lanes.clone()], &y[lanes.clone()], &z[lanes.clone()]];
            bundle.fill(origin, &self.slack[lanes.clone()], way.grain);
            way.hierarchy.nearest_of(way, bundle);
            for axis in 0..3 {
                let along = way.direction[axis];
                for (at, &distance) in self.position[axis][lanes.clone()]
                    .iter_mut()
                    .zip(&bundle.distance)
                {
                    *at += along
                        * if distance < f64::INFINITY {
                            distance
                        } else {
                            0.0
                        };
                }
            }
            self.distance.extend(&bundle.distance[..lanes.len()]);
            let met = bundle.facet.iter().zip(lanes);
            self.met
                .extend(met.map(|(facet, which)| facet << 32 | which as u64));
        }
    }
}

/// Traces packets into a tally.
pub struct Packets<'a> {
    /// What they are traced through.
    pub scene: &'a Scene,
    /// Its hierarchy.
    pub hierarchy: &'a Hierarchy,
    /// What facets do.
    pub rules: &'a Rules,
    /// Direction of launch.
    pub direction: &'a Direction,
    /// Bins of the tally.
    pub bins: &'a Bins,
    /// How exit directions are recorded, where they are.
    pub exits: Option<&'a Grid>,
    /// What bundles are traced with.
    pub instructions: InstructionSet,
    /// Packets under way, by reflections.
    pub stages: Vec<Packet>,
    /// Room for one bundle.
    pub bundle: Bundle,
}

impl Packets<'_> {
    /// Traces the rays that enter at `points`, neighbours after each other.
    pub fn trace(&mut self, points: &[DVec2], tally: &mut Tally) {
        let (scene, travel) = (self.scene, self.direction.travel);
        let ray = scene.enter(DVec2::ZERO, travel);
        let first = self.stage(0);
        first.clear();
        first.position[0].extend(points.iter().map(|point| point.x));
        first.position[1].extend(points.iter().map(|point| point.y));
        first.position[2].resize(points.len(), ray.origin.z);
        first.slack.resize(points.len(), ray.slack);
        first.point.extend(points);
        self.follow(0, None, &Course::new(self.direction), tally);
    }

    fn stage(&mut self, number: usize) -> &mut Packet {
        if self.stages.len() <= number {
            self.stages.resize_with(number + 1, Packet::default);
        }
        &mut self.stages[number]
    }

    /// Traces the packet of stage `number`, whose rays come `from` a facet or from the entrance, to the end.
    fn follow(&mut self, number: usize, from: Option<usize>, course: &Course, tally: &mut Tally) {
        let mut packet = std::mem::take(self.stage(number));
        let way = Way {
            hierarchy: self.hierarchy,
            facets: self.scene.facets(),
            direction: course.direction,
            grain: self.scene.enter(DVec2::ZERO, course.direction).grain,
            from,
        };
        self.instructions
            .advance(&mut packet, &way, &mut self.bundle);
        packet.group(self.scene.facets().len());
        for group in packet.met.chunk_by(|a, b| a >> 32 == b >> 32) {
            let members = group.iter().map(|met| *met as u32 as usize);
            let facet = group[0] >> 32;
            if facet == OUT {
                self.leave(&packet, members, course, tally);
                continue;
            }
            let number_of_facet = facet as usize;
            let facet = &self.scene.facets()[number_of_facet];
            let front = course.direction.dot(facet.normal) < 0.0;
            match course.past(facet.normal, front, self.rules) {
                Err(fate) => tally.fates[fate as usize] += group.len() as u64,
                Ok(onward) => {
                    let reach = self.scene.reach();
                    let next = self.stage(number + 1);
                    next.clear();
                    for which in members {
                        let slack =
                            facet.slack_after(course.direction, packet.distance[which], reach);
                        next.push(packet.point[which], packet.position(which), slack);
                    }
                    self.follow(number + 1, Some(number_of_facet), &onward, tally);
                }
            }
        }
        self.stages[number] = packet;
    }

    /// Counts the rays of `packet` that leave the cell.
    fn leave(
        &self,
        packet: &Packet,
        members: impl ExactSizeIterator<Item = usize>,
        course: &Course,
        tally: &mut Tally,
    ) {
        let fate = course.left(self.direction, self.rules);
        if fate != Fate::Retroreflected {
            tally.fates[fate as usize] += members.len() as u64;
            return;
        }
        let index = self.rules.refractive_index;
        let deviation = self.direction.deviation(course.direction, index);
        for which in members {
            let exit = course.at_height(self.scene.height(), packet.position(which));
            let shift = self.direction.to_frame(exit - packet.point[which]);
            tally.count_shift(self.bins, shift);
            if let Some(grid) = self.exits {
                tally.count_exit(self.bins, grid, shift, deviation);
            }
        }
    }
}

/// `items` in the order of their keys, which are below `keys`: counted, then each put in its place.
pub fn order<T: Copy>(items: &[T], keys: usize, key: impl Fn(&T) -> usize) -> Vec<T> {
    let mut next = vec![0u32; keys + 1];
    for item in items {
        next[key(item) + 1] += 1;
    }
    for key in 1..next.len() {
        next[key] += next[key - 1];
    }
    let mut ordered = items.to_vec();
    for item in items {
        let place = &mut next[key(item)];
        ordered[*place as usize] = *item;
        *place += 1;
    }
    ordered
}
