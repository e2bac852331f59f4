//! Many rays that go through a hierarchy at once, for meshes that fit no program.
//!
//! Such meshes have many facets or many kinds of bodies. All rays of a direction are parallel, and
//! rays that then meet the same facet stay parallel. A **packet** holds the rays of one course
//! ([`crate::rays::path::Course`]): they have met the same facets in the same order. A packet is
//! cut into bundles of neighbours, and each bundle goes down the hierarchy together. Then the
//! packet is grouped by the facets met, and each group goes on as a packet.

use crate::optics::Triangle;
use crate::rays::bundle::{Bundle, NONE};
use crate::rays::bvh::Hierarchy;
use crate::rays::lane::{LANES, UNITS};
use crate::rays::order::order;
use crate::rays::simd::Task;
use glam::DVec3;

/// Rays of one course: their positions, and the facets that they meet next.
#[derive(Debug, Default)]
pub(crate) struct Packet {
    /// Numbers of the entries of the rays.
    pub entry: Vec<u32>,
    /// Positions of the rays, by axis, edge lengths: first their starts, then the points on the
    /// facets that they have met.
    pub position: [Vec<f64>; 3],
    /// Bound on the error of each position, edge lengths; see [`crate::optics::Ray::slack`].
    pub slack: Vec<f64>,
    /// Distance to the facet that each ray has met, edge lengths; infinite without a facet.
    pub distance: Vec<f64>,
    /// Number of the facet met (upper 32 bits) and number of the ray, in one number to sort by.
    pub met: Vec<u64>,
}

/// Direction and facets that the rays of a packet have in common.
pub(crate) struct Way<'a> {
    /// Hierarchy over the facets.
    pub hierarchy: &'a Hierarchy,
    /// Facets that the rays can meet.
    pub facets: &'a [Triangle],
    /// Direction of travel, unit length.
    pub direction: DVec3,
    /// Bound on the rounding error of a triple product; see [`crate::optics::Ray::grain`].
    pub grain: f64,
    /// Facet that the rays come from; `None` at the entrance.
    ///
    /// The facet is plane and the rays leave to its front, so they do not meet it again.
    pub from: Option<usize>,
}

/// Number that stands for no facet in [`Packet::met`].
pub(crate) const OUT: u64 = NONE as u64;

impl Packet {
    /// Removes all rays.
    pub(crate) fn clear(&mut self) {
        self.entry.clear();
        self.position.iter_mut().for_each(Vec::clear);
        self.slack.clear();
        self.distance.clear();
        self.met.clear();
    }

    /// Takes the `members` of another packet in place of the rays so far.
    ///
    /// `slack` returns the bound on the error of the position of a ray after its distance.
    pub(crate) fn take(
        &mut self,
        other: &Packet,
        members: impl ExactSizeIterator<Item = usize> + Clone,
        slack: impl Fn(f64) -> f64,
    ) {
        self.clear();
        // One list after the other, because each is then filled without looking at its room.
        self.entry
            .extend(members.clone().map(|which| other.entry[which]));
        for (own, others) in self.position.iter_mut().zip(&other.position) {
            own.extend(members.clone().map(|which| others[which]));
        }
        self.slack
            .extend(members.map(|which| slack(other.distance[which])));
    }

    /// Returns the position of ray number `which`, edge lengths.
    pub(crate) fn position(&self, which: usize) -> DVec3 {
        let [x, y, z] = &self.position;
        DVec3::new(x[which], y[which], z[which])
    }

    /// Brings rays that have met the same facet together; `facets` is the number of facets.
    ///
    /// Rays of one facet stay in their order.
    pub(crate) fn group(&mut self, facets: usize) {
        if self.met.len() < facets {
            gather(&mut self.met);
        } else {
            let order = order(&self.met, facets + 1, |met| {
                (met >> 32).min(facets as u64) as usize
            });
            self.met = order;
        }
    }

    /// Moves every ray to the nearest facet.
    #[inline(always)]
    fn advance(&mut self, way: &Way, bundle: &mut Bundle) {
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
            let met = bundle.met();
            for axis in 0..3 {
                let along = way.direction[axis];
                for (at, &distance) in self.position[axis][lanes.clone()]
                    .iter_mut()
                    .zip(&met.distance)
                {
                    *at += along
                        * if distance < f64::INFINITY {
                            distance
                        } else {
                            0.0
                        };
                }
            }
            self.distance.extend(&met.distance[..lanes.len()]);
            // The low bits of a number with `UNITS` are the number.
            let facets = met.facet.iter().zip(lanes);
            self.met.extend(
                facets.map(|(facet, which)| (facet + UNITS).to_bits() << 32 | which as u64),
            );
        }
    }
}

/// Brings numbers with the same upper half together. Those of one half stay in their order.
///
/// The rays of a packet meet few facets. So each pass takes one facet out of what is left. If many
/// facets are left after some passes, sorting is quicker.
fn gather(met: &mut [u64]) {
    let mut others = vec![0; met.len()];
    let mut start = 0;
    for _ in 0..PASSES {
        let Some(&first) = met.get(start) else {
            return;
        };
        // Each number is written to both places, for a branch would often be guessed wrong.
        let (from, mut other) = (start, 0);
        for at in from..met.len() {
            let one = met[at];
            let same = one >> 32 == first >> 32;
            (met[start], others[other]) = (one, one);
            start += usize::from(same);
            other += usize::from(!same);
        }
        met[start..].copy_from_slice(&others[..other]);
    }
    met[start..].sort_unstable();
}

/// Number of facets after which the rest of a packet is sorted.
const PASSES: usize = 8;

/// Step of a packet: the arguments of [`Packet::advance`].
pub(crate) struct Advance<'a> {
    /// Packet whose rays move.
    pub packet: &'a mut Packet,
    /// Direction and facets that its rays have in common.
    pub way: &'a Way<'a>,
    /// Working memory for one bundle.
    pub bundle: &'a mut Bundle,
}

impl Task for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.packet.advance(self.way, self.bundle);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lists of 0 to 200 rays that have met 1 to 40 facets, none of them or all beside each other:
    /// every facet has its rays in one run, in their order.
    #[test]
    fn rays_of_one_facet_come_together_in_their_order() {
        let mut cases = 0;
        for count in [0, 1, 2, 7, 64, 200] {
            for facets in [1, 2, 8, 9, 40] {
                let facet = |ray: u64| ((ray * 2_654_435_769) >> 7) % facets;
                let met: Vec<u64> = (0..count).map(|ray| facet(ray) << 32 | ray).collect();
                let mut found = met.clone();
                gather(&mut found);
                let runs: Vec<&[u64]> = found.chunk_by(|a, b| a >> 32 == b >> 32).collect();
                for (number, run) in runs.iter().enumerate() {
                    assert!(run.is_sorted());
                    let again = |other: &&[u64]| other[0] >> 32 == run[0] >> 32;
                    assert!(!runs[number + 1..].iter().any(again), "{count} {facets}");
                }
                found.sort_unstable();
                let mut all = met;
                all.sort_unstable();
                assert_eq!(found, all);
                cases += 1;
            }
        }
        assert_eq!(cases, 6 * 5);
    }
}
