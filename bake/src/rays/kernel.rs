//! Tracer of one direction: it takes every ray of a run from its sample to the accumulator. And the
//! sheet that it traces: one scene, or one scene for each kind of body of the cell.

use crate::cell::Prepared;
use crate::geometry::{Launch, Stream};
use crate::optics::{Incidence, Rules, element};
use crate::rays::accumulator::{Accumulator, Bins};
use crate::rays::departures::Departures;
use crate::rays::entries::neighbours;
use crate::rays::entries::{EntryPoint, SampleRange, entries};
use crate::rays::hierarchy::bvh::Hierarchy;
use crate::rays::hierarchy::groups::{MOST_RAYS, RayGroup};
use crate::rays::path::{Outcome, RandomNumbers, trace};
use crate::rays::programs::exits::NumberedExits;
use crate::rays::programs::lanes;
use crate::rays::programs::lanes::Batch;
use crate::rays::programs::program::Program;
use crate::rays::rough::{RoughBatch, RoughTracing};
use crate::rays::scene::{Index, Scene};
use crate::rays::simd::InstructionSet;
use std::ops::Range;
use std::sync::Arc;
use tables::Fate;
use tables::deviation::Grid;
use tables::options::{Element, Roughness};

/// Number of rays in one piece of work.
///
/// It is large enough to make the adding of its histogram cheap, and small enough to spread over
/// threads.
const RUN: u64 = 1 << 18;

/// Number of rays in one piece of work where rays are sorted by the facets that they meet.
///
/// More rays in a piece mean more rays that meet the same facet, so the piece is larger.
const RUN_OF_SORTED: u64 = 1 << 20;

/// Largest number of rays in one piece of work where neighbours go down a hierarchy together.
///
/// Pieces of half the size take 15 % longer on a mesh of 2,048 cubes.
const RUN_OF_NEIGHBOURS: u64 = 1 << 21;

/// Way in which the rays of a direction are traced.
///
/// Tests check that both ways give every ray the same fate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tracer {
    /// Many rays at once as a program, where the cell and the direction allow it; otherwise one by
    /// one.
    Fastest,
    /// One ray after the other, against all facets, as every cell allows.
    OneByOne,
}

/// Everything that all rays of one direction share.
pub(crate) struct Kernel {
    /// Scenes that the launch leads into.
    scenes: Vec<Arc<Scene>>,
    launch: Launch,
    rules: Rules,
    bins: Bins,
    incidence_rad: f64,
    /// Direction of the rays; `None` if every ray has its own azimuth.
    direction: Option<Incidence>,
    /// Programs that trace many rays at once, one per scene; empty if any scene allows none.
    programs: Vec<Program>,
    instructions: InstructionSet,
    /// Roughness of facets whose rays go side by side; `None` if they go one by one.
    rough: Option<Roughness>,
    /// True if rays go down the hierarchy of every scene together, in groups.
    grouped: bool,
    /// Grid that exit directions are recorded on; `None` if they are not recorded.
    exits: Option<Grid>,
    /// Exit directions of the programs, where they are recorded.
    exits_of_programs: Option<NumberedExits>,
}

impl Kernel {
    /// Makes the tracer of one scene for the direction with these angles, degrees.
    ///
    /// An azimuth of NaN stands for all azimuths.
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

    /// Makes the tracer of a sheet for the direction with these angles, degrees.
    ///
    /// An azimuth of NaN stands for all azimuths.
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
        // Each ray goes alone in these cases: a rough facet turns each ray in its own way, and rays
        // diverge on curved faces. Programs also assume that paths end at the entrance
        // plane, where they first meet it, and that no facet is of glass.
        let alone = rules.roughness.is_some()
            || rules.element != Element::Retroreflector
            || rules.glass_index.is_some()
            || rules.follows_the_front()
            || scenes.iter().any(|scene| scene.is_curved());
        let side_by_side = direction.is_some()
            && rules.losses.is_none()
            && rules.glass_index.is_none()
            && !rules.follows_the_front()
            && scenes.iter().all(|scene| scene.is_flown_through());
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
            rough: rules.roughness.filter(|_| side_by_side),
            instructions: InstructionSet::best(),
            grouped: scenes.iter().all(|scene| scene.for_groups().is_some()),
            exits: None,
            exits_of_programs: None,
            scenes: scenes.clone(),
            launch: launch.clone(),
            rules: *rules,
            bins: *bins,
            incidence_rad,
            direction,
        }
    }

    /// Returns the tracer without programs and groups, so that every ray goes by [`trace`].
    pub(crate) fn one_by_one(self) -> Self {
        Kernel {
            programs: Vec::new(),
            rough: None,
            grouped: false,
            ..self
        }
    }

    /// Returns the tracer that traces in the way of `tracer`.
    pub(crate) fn by(self, tracer: Tracer) -> Self {
        match tracer {
            Tracer::Fastest => self,
            Tracer::OneByOne => self.one_by_one(),
        }
    }

    /// Returns the tracer that records exit directions too, if there is a grid for them.
    ///
    /// It runs no programs if these have too many exit directions to be numbered.
    pub(crate) fn recording(self, exits: Option<Grid>) -> Self {
        let Some(grid) = &exits else {
            return self;
        };
        let exits_of_programs = NumberedExits::new(&self.programs, grid, &self.bins);
        Kernel {
            programs: match exits_of_programs {
                Some(_) => self.programs,
                None => Vec::new(),
            },
            exits,
            exits_of_programs,
            ..self
        }
    }

    /// Returns the tracer that runs on `instructions`.
    #[cfg(test)]
    pub(crate) fn on(self, instructions: InstructionSet) -> Self {
        Kernel {
            instructions,
            ..self
        }
    }

    /// Returns whether rays of rough facets go side by side.
    #[cfg(test)]
    pub(crate) fn flies(&self) -> bool {
        self.rough.is_some()
    }

    /// Returns the programs of this direction, one per scene; empty if rays are traced facet by
    /// facet.
    pub(crate) fn programs(&self) -> &[Program] {
        &self.programs
    }

    /// Returns the number of rays that are best traced in one piece, if every thread has so many
    /// `rays` to trace.
    pub(crate) fn run(&self, rays: u64) -> u64 {
        if self.mixes() {
            rays.clamp(RUN, RUN_OF_NEIGHBOURS)
        } else if lanes::sorts(&self.launch) {
            RUN_OF_SORTED
        } else {
            RUN
        }
    }

    /// Returns whether samples of several randomisations are best traced in one piece.
    ///
    /// They are where rays go down a hierarchy beside their neighbours.
    pub(crate) fn mixes(&self) -> bool {
        self.programs.is_empty() && self.rough.is_none() && (self.grouped || self.is_large())
    }

    /// Returns whether any scene is large ([`Scene::is_large`]).
    fn is_large(&self) -> bool {
        self.scenes.iter().any(|scene| scene.is_large())
    }

    /// Traces `samples` of `stream` into `accumulator`.
    #[cfg(test)]
    pub(crate) fn trace(
        &self,
        stream: &Stream,
        samples: Range<u64>,
        accumulator: &mut Accumulator,
    ) {
        let part = SampleRange {
            stream: *stream,
            samples,
        };
        self.trace_parts(&[part], std::slice::from_mut(accumulator));
    }

    /// Traces each of `parts` into its accumulator.
    pub(crate) fn trace_parts(&self, parts: &[SampleRange], accumulators: &mut [Accumulator]) {
        if self.programs.is_empty() && self.rough.is_none() {
            return self.trace_paths(parts, accumulators);
        }
        for (SampleRange { stream, samples }, accumulator) in parts.iter().zip(accumulators) {
            if let (Some(roughness), Some(direction)) = (self.rough, &self.direction) {
                self.trace_rough(roughness, direction, stream, samples.clone(), accumulator);
                continue;
            }
            let batch = Batch {
                programs: &self.programs,
                launch: &self.launch,
                bins: &self.bins,
                stream,
                samples: samples.clone(),
                exits: self.exits_of_programs.as_ref(),
            };
            batch.trace(self.instructions, accumulator);
        }
    }

    /// Traces `samples` side by side, each ray in a direction of its own.
    fn trace_rough(
        &self,
        roughness: Roughness,
        direction: &Incidence,
        stream: &Stream,
        samples: Range<u64>,
        accumulator: &mut Accumulator,
    ) {
        let batch = RoughBatch {
            scenes: &self.scenes,
            launch: &self.launch,
            rules: &self.rules,
            roughness,
            direction,
            stream,
            samples,
        };
        let exits = self.exits.as_ref();
        let mut departures = Departures::new(direction, &self.rules, &self.bins, exits);
        self.instructions.run(RoughTracing {
            batch: &batch,
            departures: &mut departures,
            accumulator,
        });
    }

    /// Traces the samples of `parts` facet by facet: in groups if every scene allows them,
    /// otherwise one by one.
    fn trace_paths(&self, parts: &[SampleRange], accumulators: &mut [Accumulator]) {
        let hierarchies = self.scenes.iter().map(|scene| scene.for_groups());
        let hierarchies: Option<Vec<&Hierarchy>> = hierarchies.collect();
        match hierarchies {
            Some(hierarchies) if self.grouped => {
                self.trace_groups(&hierarchies, parts, accumulators);
            }
            _ => self.trace_alone(parts, accumulators),
        }
    }

    /// Traces the samples of `parts` in groups.
    fn trace_groups(
        &self,
        hierarchies: &[&Hierarchy],
        parts: &[SampleRange],
        accumulators: &mut [Accumulator],
    ) {
        for (number, (scene, &hierarchy)) in self.scenes.iter().zip(hierarchies).enumerate() {
            let mut group = RayGroup::new(scene, hierarchy, &self.rules);
            for neighbours in self.neighbours(number, parts).chunks(MOST_RAYS) {
                let path = |entry: &EntryPoint| {
                    let (stream, index) = entry.sample(parts);
                    let direction = self.direction_of(stream, index);
                    (direction, entry.point, self.random(stream, index))
                };
                group.trace(neighbours.iter().map(path), |which, direction, outcome| {
                    let accumulator = &mut accumulators[neighbours[which].part()];
                    self.count(direction, outcome, accumulator);
                });
            }
        }
    }

    /// Returns the rays that enter scene number `scene`, sorted into tiles.
    fn neighbours(&self, scene: usize, parts: &[SampleRange]) -> Vec<EntryPoint> {
        neighbours(&self.launch, parts, scene, self.instructions)
    }

    /// Returns the direction of sample `index` of `stream`.
    fn direction_of(&self, stream: &Stream, index: u64) -> Incidence {
        self.direction.unwrap_or_else(|| {
            let azimuth_rad = self.launch.azimuth_rad(stream, index);
            Incidence::new(self.incidence_rad, azimuth_rad, self.rules.refractive_index)
        })
    }

    /// Returns the random numbers of sample `index` of `stream`.
    fn random(&self, stream: &Stream, index: u64) -> RandomNumbers {
        let chance = match self.rules.losses {
            Some(_) => self.launch.chance(stream, index),
            None => 0.5,
        };
        RandomNumbers {
            chance,
            sample: (*stream, index),
        }
    }

    /// Traces `samples` ray by ray with [`trace`].
    #[cfg(test)]
    pub(crate) fn trace_one_by_one(
        &self,
        stream: &Stream,
        samples: Range<u64>,
        accumulator: &mut Accumulator,
    ) {
        let part = SampleRange {
            stream: *stream,
            samples,
        };
        self.trace_alone(&[part], std::slice::from_mut(accumulator));
    }

    /// Traces the samples of `parts` ray by ray with [`trace`].
    fn trace_alone(&self, parts: &[SampleRange], accumulators: &mut [Accumulator]) {
        if !self.is_large() {
            return self.trace_entries(parts, entries(&self.launch, parts), accumulators);
        }
        // The facets that a neighbour has met are still in the cache.
        for scene in 0..self.scenes.len() {
            let entries = self.neighbours(scene, parts).into_iter();
            self.trace_entries(parts, entries.map(|entry| (scene, entry)), accumulators);
        }
    }

    /// Traces the samples of `entries`, which belong to `parts`.
    fn trace_entries(
        &self,
        parts: &[SampleRange],
        entries: impl Iterator<Item = (usize, EntryPoint)>,
        accumulators: &mut [Accumulator],
    ) {
        for (scene, entry) in entries {
            let (stream, index) = entry.sample(parts);
            let direction = self.direction_of(stream, index);
            let random = self.random(stream, index);
            let scene = &self.scenes[scene];
            let outcome = trace(scene, &self.rules, &direction, entry.point, random);
            self.count(&direction, &outcome, &mut accumulators[entry.part()]);
        }
    }

    /// Counts the ray that was launched along `direction`.
    fn count(&self, direction: &Incidence, outcome: &Outcome, accumulator: &mut Accumulator) {
        accumulator.count(&self.bins, outcome);
        if let (Some(grid), Fate::Retroreflected) = (&self.exits, outcome.fate) {
            let back = element::straight_back(self.rules.element, outcome.travel);
            let deviation = direction.deviation(back, self.rules.refractive_index);
            accumulator.count_exit(&self.bins, grid, outcome.shift, deviation);
        }
    }
}

/// Scenes that rays are launched into, and the shares of the rays among them.
pub(crate) struct Sheet {
    /// All scenes; a ray meets facets of one scene only.
    pub scenes: Vec<Arc<Scene>>,
    /// Map from samples to entry points and the scenes that they belong to.
    pub launch: Launch,
}

impl Sheet {
    /// Makes the sheet of a cell, with a scene for each kind of body if there are kinds.
    ///
    /// [`Prepared::kinds`] says whether the cell is taken apart into bodies.
    pub(crate) fn new(prepared: &Prepared, index: Index) -> Self {
        let cell = prepared.cell();
        let Ok(kinds) = prepared.kinds() else {
            return Sheet {
                scenes: vec![Arc::new(Scene::new(cell, index))],
                launch: Launch::new(&cell.entrance),
            };
        };
        let shares: Vec<_> = kinds
            .iter()
            .map(|kind| (&kind.entrance, kind.places.len()))
            .collect();
        Sheet {
            launch: Launch::among(&shares),
            scenes: kinds
                .iter()
                .map(|kind| Arc::new(Scene::of(&kind.facets, &kind.entrance, index)))
                .collect(),
        }
    }
}
