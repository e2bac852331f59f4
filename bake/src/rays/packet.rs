//! Many rays through a hierarchy at once, for meshes that no program fits (curved, or of many
//! different cells).
//!
//! All rays of a direction travel alike, and those that then meet the same facet go on alike. A
//! **packet** is the rays of one [`Course`]: the same facets in the same order. It is cut into
//! bundles of neighbours, each of which goes down the hierarchy together; then the packet is
//! grouped by the facets met, and each group goes on as a packet.

use crate::optics::Triangle;
use crate::rays::bundle::{Bundle, NONE};
use crate::rays::bvh::Hierarchy;
use crate::rays::lane::LANES;
use crate::rays::order::order;
use glam::{DVec2, DVec3};

/// Rays of one course: where they are, and what they meet next.
#[derive(Debug, Default)]
pub(crate) struct Packet {
    /// Where they entered.
    pub point: Vec<DVec2>,
    /// Where they are, by axis: first where they start, then where they have met a facet.
    pub position: [Vec<f64>; 3],
    /// As [`crate::optics::Ray::slack`].
    pub slack: Vec<f64>,
    /// Distance to what they have met.
    pub distance: Vec<f64>,
    /// Triangle met, then number of the ray, in one number to sort by.
    pub met: Vec<u64>,
}

/// What the rays of a packet go through, and how.
pub(crate) struct Way<'a> {
    /// Hierarchy over the facets.
    pub hierarchy: &'a Hierarchy,
    /// What they can meet.
    pub facets: &'a [Triangle],
    /// Incidence of travel.
    pub direction: DVec3,
    /// As [`crate::optics::Ray::grain`].
    pub grain: f64,
    /// The facet that they come from: it is plane and they leave to its front, so they do not meet
    /// it.
    pub from: Option<usize>,
}

/// No facet, in [`Packet::met`].
pub(crate) const OUT: u64 = NONE >> 32;

impl Packet {
    /// Forgets all rays.
    pub(crate) fn clear(&mut self) {
        self.point.clear();
        self.position.iter_mut().for_each(Vec::clear);
        self.slack.clear();
        self.distance.clear();
        self.met.clear();
    }

    /// Adds a ray that entered at `point` and is at `position`.
    pub(crate) fn push(&mut self, point: DVec2, position: DVec3, slack: f64) {
        let [x, y, z] = &mut self.position;
        self.point.push(point);
        x.push(position.x);
        y.push(position.y);
        z.push(position.z);
        self.slack.push(slack);
    }

    /// Where ray number `which` is.
    pub(crate) fn position(&self, which: usize) -> DVec3 {
        let [x, y, z] = &self.position;
        DVec3::new(x[which], y[which], z[which])
    }

    /// Puts rays that have met the same facet, of so many, after each other.
    pub(crate) fn group(&mut self, facets: usize) {
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
    pub(crate) fn advance(&mut self, way: &Way, bundle: &mut Bundle) {
        let count = self.slack.len();
        self.distance.reserve(count);
        self.met.reserve(count);
        for first in (0..count).step_by(LANES) {
            let lanes = first..count.min(first + LANES);
            let [x, y, z] = &self.position;
            let origin = [&x[lanes.clone()], &y[lanes.clone()], &z[lanes.clone()]];
            bundle.fill(origin, &self.slack[lanes.clone()], way.grain);
            way.hierarchy
                .nearest_of(way.facets, way.direction, way.from, bundle);
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
