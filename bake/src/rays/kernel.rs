//! The tracer of one direction: every ray of a run from its sample to the tally.

use crate::optics::{Incidence, Rules, element};
use crate::rays::bins::Bins;
use crate::rays::bundle::Bundle;
use crate::rays::bvh::Hierarchy;
use crate::rays::lane::LANES;
use crate::rays::lanes;
use crate::rays::lanes::Batch;
use crate::rays::order::order;
use crate::rays::packets::Packets;
use crate::rays::path::{Luck, trace};
use crate::rays::program::Program;
use crate::rays::scene::Scene;
use crate::rays::sheet::Sheet;
use crate::rays::simd::InstructionSet;
use crate::rays::tally::Tally;
use crate::samples::{Launch, Stream};
use glam::DVec2;
use std::ops::Range;
use std::sync::Arc;
use tables::Fate;
use tables::deviation::Grid;
use tables::options::Element;

/// Rays in one piece of work: enough to make adding its histogram cheap, few enough to spread over
/// threads.
const RUN: u64 = 1 << 18;

/// The same where they are sorted by what they meet, which is the better the more rays meet the
/// same.
const RUN_OF_SORTED: u64 = 1 << 20;

/// Rays that are sorted into packets at a time: 80 bytes each.
const NEIGHBOURS: usize = 1 << 18;

/// Rays to a facet from which on packets are worth while in a large scene: a packet is what met the
/// same facets.
const RAYS_OF_PACKETS: u64 = 8;

/// How the rays of a direction are traced; tests hold both to the same fates, ray for ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tracer {
    /// As a program, many rays at once, where the cell and the direction allow it; else one by one.
    Fastest,
    /// One by one, against all facets: what every cell allows.
    OneByOne,
}

/// What all rays of one direction share.
pub(crate) struct Kernel {
    /// Those that the launch leads into.
    scenes: Vec<Arc<Scene>>,
    launch: Launch,
    rules: Rules,
    bins: Bins,
    incidence_rad: f64,
    /// `None` where every ray has its own azimuth.
    direction: Option<Incidence>,
    /// The same in a form that many rays run at once, one per scene; none where a scene does not
    /// allow it.
    programs: Vec<Program>,
    instructions: InstructionSet,
    /// Whether scenes with a hierarchy are traced in packets.
    packets: bool,
    /// How exit directions are recorded.
    exits: Option<Grid>,
}

impl Kernel {
    /// The tracer for the direction given by its angles in degrees; an azimuth of NaN stands for
    /// all azimuths.
    #[cfg(test)]
    pub(crate) fn new(
        scene: &Arc<Scene>,
        launch: &Launch,
        rules: &Rules,
        bins: &Bins,
        incidence_deg: f64,
        azimuth_deg: f64,
    ) -> Self {
        let sheet = Sheet {
            scenes: vec![Arc::clone(scene)],
            launch: launch.clone(),
        };
        Kernel::over(&sheet, rules, bins, incidence_deg, azimuth_deg)
    }

    /// The same over a sheet.
    pub(crate) fn over(
        sheet: &Sheet,
        rules: &Rules,
        bins: &Bins,
        incidence_deg: f64,
        azimuth_deg: f64,
    ) -> Self {
        let Sheet { scenes, launch } = sheet;
        let incidence_rad = incidence_deg.to_radians();
        let direction = (!azimuth_deg.is_nan()).then(|| {
            Incidence::new(
                incidence_rad,
                azimuth_deg.to_radians(),
                rules.refractive_index,
            )
        });
        // Photons end where their own chance says, rough facets turn each its own way, and on
        // curved faces rays part: each goes alone. Programs and packets end on the entrance plane.
        let alone = rules.losses.is_some()
            || rules.roughness.is_some()
            || rules.element != Element::Retroreflector
            || rules.glass_index.is_some()
            || scenes.iter().any(|scene| scene.is_curved());
        let mut entries = vec![Vec::new(); scenes.len()];
        for piece in launch.pieces() {
            entries[piece.scene].push(piece.polygon());
        }
        let programs = scenes
            .iter()
            .zip(entries)
            .map(|(scene, entry)| Program::new(scene, entry, rules, &direction?, bins));
        let programs: Option<Vec<Program>> = if alone { None } else { programs.collect() };
        Kernel {
            programs: programs.unwrap_or_default(),
            instructions: InstructionSet::best(),
            // With an azimuth of its own for each, rays part at once.
            packets: direction.is_some() && !alone,
            exits: None,
            scenes: scenes.clone(),
            launch: launch.clone(),
            rules: *rules,
            bins: *bins,
            incidence_rad,
            direction,
        }
    }

    /// The same tracer without a program: every ray goes by [`trace`].
    pub(crate) fn one_by_one(self) -> Self {
        Kernel {
            programs: Vec::new(),
            packets: false,
            ..self
        }
    }

    /// The same tracer in the way that `tracer` says.
    pub(crate) fn by(self, tracer: Tracer) -> Self {
        match tracer {
            Tracer::Fastest => self,
            Tracer::OneByOne => self.one_by_one(),
        }
    }

    /// The same tracer, which also records exit directions where there is a grid for them: without
    /// programs, which know shifts only.
    pub(crate) fn recording(self, exits: Option<Grid>) -> Self {
        match exits {
            None => self,
            Some(_) => Kernel {
                programs: Vec::new(),
                exits,
                ..self
            },
        }
    }

    /// The same tracer on `instructions`.
    #[cfg(test)]
    pub(crate) fn on(self, instructions: InstructionSet) -> Self {
        Kernel {
            instructions,
            ..self
        }
    }

    /// The programs of this direction, one per scene; none where it is traced facet by facet.
    pub(crate) fn programs(&self) -> &[Program] {
        &self.programs
    }

    /// Rays that are best traced in one piece.
    pub(crate) fn run(&self) -> u64 {
        let sorted = self.programs.is_empty() && (self.packets || self.is_large())
            || lanes::sorts(&self.launch);
        if sorted { RUN_OF_SORTED } else { RUN }
    }

    fn is_large(&self) -> bool {
        self.scenes.iter().any(|scene| scene.is_large())
    }

    /// Traces `samples` of `stream` into `tally`.
    pub(crate) fn trace(&self, stream: &Stream, samples: Range<u64>, tally: &mut Tally) {
        match &self.programs[..] {
            [] => self.trace_paths(stream, samples, tally),
            programs => {
                let batch = Batch {
                    programs,
                    launch: &self.launch,
                    bins: &self.bins,
                    stream,
                    samples,
                };
                self.instructions.run(&batch, tally);
            }
        }
    }

    /// The same facet by facet: in packets where every scene has a hierarchy for them, else by
    /// [`trace`].
    fn trace_paths(&self, stream: &Stream, samples: Range<u64>, tally: &mut Tally) {
        let hierarchies = self.scenes.iter().map(|scene| scene.for_packets());
        let hierarchies: Option<Vec<&Hierarchy>> = hierarchies.collect();
        let (Some(direction), Some(hierarchies), true) =
            (&self.direction, hierarchies, self.packets)
        else {
            return self.trace_one_by_one(stream, samples, tally);
        };
        // Rays that hardly ever meet the same facet are no packet.
        let facets: usize = self.scenes.iter().map(|scene| scene.facets().len()).sum();
        if self.is_large() && samples.end - samples.start < RAYS_OF_PACKETS * facets as u64 {
            return self.trace_one_by_one(stream, samples, tally);
        }
        for (number, (scene, hierarchy)) in self.scenes.iter().zip(hierarchies).enumerate() {
            let entries = samples
                .clone()
                .map(|index| self.launch.entry(stream, index));
            let points = entries.filter(|entry| entry.0 == number);
            let points: Vec<DVec2> = points.map(|entry| entry.1).collect();
            let points = side_by_side(&self.launch, &points, |point| *point);
            let mut packets = Packets {
                scene,
                hierarchy,
                rules: &self.rules,
                direction,
                bins: &self.bins,
                exits: self.exits.as_ref(),
                instructions: self.instructions,
                stages: Vec::new(),
                bundle: Bundle::new(),
            };
            for neighbours in points.chunks(NEIGHBOURS) {
                packets.trace(neighbours, tally);
            }
        }
    }

    fn direction_of(&self, stream: &Stream, index: u64) -> Incidence {
        self.direction.unwrap_or_else(|| {
            let azimuth_rad = self.launch.azimuth_rad(stream, index);
            Incidence::new(self.incidence_rad, azimuth_rad, self.rules.refractive_index)
        })
    }

    /// The same by [`trace`], ray by ray.
    pub(crate) fn trace_one_by_one(&self, stream: &Stream, samples: Range<u64>, tally: &mut Tally) {
        let entries = samples.map(|index| (index, self.launch.entry(stream, index)));
        if !self.is_large() {
            return self.trace_entries(stream, entries, tally);
        }
        // What neighbours meet is still at hand.
        let entries: Vec<(u64, (usize, DVec2))> = entries.collect();
        for some in entries.chunks(RUN_OF_SORTED as usize) {
            let some = side_by_side(&self.launch, some, |entry| entry.1.1);
            self.trace_entries(stream, some.into_iter(), tally);
        }
    }

    /// Traces the samples numbered, which enter a scene at a point.
    fn trace_entries(
        &self,
        stream: &Stream,
        entries: impl Iterator<Item = (u64, (usize, DVec2))>,
        tally: &mut Tally,
    ) {
        for (index, (scene, point)) in entries {
            let direction = self.direction_of(stream, index);
            let chance = match self.rules.losses {
                Some(_) => self.launch.chance(stream, index),
                None => 0.5,
            };
            let luck = Luck {
                chance,
                sample: (*stream, index),
            };
            let scene = &self.scenes[scene];
            let outcome = trace(scene, &self.rules, &direction, point, luck);
            tally.count(&self.bins, &outcome);
            if let (Some(grid), Fate::Retroreflected) = (&self.exits, outcome.fate) {
                let back = element::straight_back(self.rules.element, outcome.travel);
                let deviation = direction.deviation(back, self.rules.refractive_index);
                tally.count_exit(&self.bins, grid, outcome.shift, deviation);
            }
        }
    }
}

/// Rays in the order of the tiles of the entrance that their points lie in, each with about as many
/// as a bundle takes.
fn side_by_side<T: Copy>(launch: &Launch, rays: &[T], point: impl Fn(&T) -> DVec2) -> Vec<T> {
    let [low, high] = launch.box_of_entrance();
    let size = high - low;
    // Square tiles; no more than the longer side can be counted in.
    let tiles = (rays.len() / LANES).max(1) as f64;
    let side = (size.x * size.y / tiles)
        .sqrt()
        .max(size.max_element() / 65_536.0);
    let last = (size / side).floor();
    let columns = last.x as usize + 1;
    order(rays, columns * (last.y as usize + 1), |ray| {
        let tile = ((point(ray) - low) / side).clamp(DVec2::ZERO, last);
        tile.y as usize * columns + tile.x as usize
    })
}
