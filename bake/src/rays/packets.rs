//! Packets from the entrance to their end: each is advanced, grouped by the facets met, and
//! followed.

use crate::optics::{Incidence, Rules};
use crate::rays::bins::Bins;
use crate::rays::bundle::Bundle;
use crate::rays::bvh::Hierarchy;
use crate::rays::entries::Entry;
use crate::rays::packet::{Advance, OUT, Packet, Way};
use crate::rays::path::Course;
use crate::rays::scene::Scene;
use crate::rays::simd::InstructionSet;
use crate::rays::tally::Tally;
use glam::DVec2;
use tables::Fate;
use tables::deviation::Grid;

/// Tracer of packets for one scene and one direction.
pub(crate) struct Packets<'a> {
    /// Scene that the packets go through.
    pub scene: &'a Scene,
    /// Hierarchy of the scene.
    pub hierarchy: &'a Hierarchy,
    /// Rules by which facets change light.
    pub rules: &'a Rules,
    /// Direction of launch and its frame.
    pub direction: &'a Incidence,
    /// Bins of the tally.
    pub bins: &'a Bins,
    /// Grid that exit directions are recorded on; `None` if they are not recorded.
    pub exits: Option<&'a Grid>,
    /// Instruction set that bundles are traced with.
    pub instructions: InstructionSet,
    /// Rays at the entrance.
    pub entries: &'a [Entry],
    /// Packets under way, by the number of their reflections.
    pub stages: Vec<Packet>,
    /// Working memory for one bundle.
    pub bundle: Bundle,
}

impl<'a> Packets<'a> {
    /// Traces the rays of `entries`, of which neighbours come after each other.
    ///
    /// Each ray is counted in the tally of its part.
    pub(crate) fn trace(&mut self, entries: &'a [Entry], tallies: &mut [Tally]) {
        self.entries = entries;
        let (scene, travel) = (self.scene, self.direction.travel);
        let ray = scene.enter(DVec2::ZERO, travel);
        let first = self.stage(0);
        first.clear();
        first.position[0].extend(entries.iter().map(|entry| entry.point.x));
        first.position[1].extend(entries.iter().map(|entry| entry.point.y));
        first.position[2].resize(entries.len(), ray.origin.z);
        first.slack.resize(entries.len(), ray.slack);
        first.entry.extend(0..entries.len() as u32);
        self.follow(0, None, &Course::new(self.direction), tallies);
    }

    /// Returns the packet after `number` reflections, and makes room for it first.
    fn stage(&mut self, number: usize) -> &mut Packet {
        if self.stages.len() <= number {
            self.stages.resize_with(number + 1, Packet::default);
        }
        &mut self.stages[number]
    }

    /// Traces the packet of stage `number` to the end; its rays come `from` a facet or from the
    /// entrance.
    fn follow(
        &mut self,
        number: usize,
        from: Option<usize>,
        course: &Course,
        tallies: &mut [Tally],
    ) {
        let mut packet = std::mem::take(self.stage(number));
        let way = Way {
            hierarchy: self.hierarchy,
            facets: self.scene.facets(),
            direction: course.direction,
            grain: self.scene.enter(DVec2::ZERO, course.direction).grain,
            from,
        };
        self.instructions.run(Advance {
            packet: &mut packet,
            way: &way,
            bundle: &mut self.bundle,
        });
        packet.group(self.scene.facets().len());
        for group in packet.met.chunk_by(|a, b| a >> 32 == b >> 32) {
            let members = group.iter().map(|met| *met as u32 as usize);
            let facet = group[0] >> 32;
            if facet == OUT {
                self.leave(&packet, members, course, tallies);
                continue;
            }
            let number_of_facet = facet as usize;
            let facet = &self.scene.facets()[number_of_facet];
            let front = course.direction.dot(facet.normal) < 0.0;
            match course.past(facet.normal, front, self.rules) {
                Err(fate) => self.end(&packet, members, fate, tallies),
                Ok(onward) => {
                    let reach = self.scene.reach();
                    let slack = |distance| facet.slack_after(course.direction, distance, reach);
                    self.stage(number + 1).take(&packet, members, slack);
                    self.follow(number + 1, Some(number_of_facet), &onward, tallies);
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
        tallies: &mut [Tally],
    ) {
        let fate = course.left(self.direction, self.rules);
        if fate != Fate::Retroreflected {
            return self.end(packet, members, fate, tallies);
        }
        let index = self.rules.refractive_index;
        let deviation = self.direction.deviation(course.direction, index);
        for which in members {
            let exit = course.at_height(self.scene.height(), packet.position(which));
            let entry = &self.entries[packet.entry[which] as usize];
            let shift = self.direction.to_frame(exit - entry.point);
            let tally = &mut tallies[entry.part()];
            tally.count_shift(self.bins, shift);
            if let Some(grid) = self.exits {
                tally.count_exit(self.bins, grid, shift, deviation);
            }
        }
    }

    /// Counts the `members` of `packet`, which all have the fate given.
    fn end(
        &self,
        packet: &Packet,
        members: impl ExactSizeIterator<Item = usize>,
        fate: Fate,
        tallies: &mut [Tally],
    ) {
        if let [tally] = tallies {
            tally.fates[fate as usize] += members.len() as u64;
            return;
        }
        for which in members {
            let entry = &self.entries[packet.entry[which] as usize];
            tallies[entry.part()].fates[fate as usize] += 1;
        }
    }
}
