//! The tracer of one direction: every ray of a run from its sample to the tally.

use crate::bundle::{Bundle, NEIGHBOURS};
use crate::bvh::Hierarchy;
use crate::lanes::LANES;
use crate::launch::{Launch, Piece};
use crate::path::{Path, Rules, trace};
use crate::program::Program;
use crate::ray::Direction;
use crate::scene::Scene;
use crate::sequence::Stream;
use crate::sheet::Sheet;
use crate::simd::InstructionSet;
use crate::tally::{Bins, Tally};
use glam::DVec2;
use std::ops::Range;
use std::sync::Arc;

/// What all rays of one direction share.
pub struct Kernel {
    /// Those that the launch leads into.
    scenes: Vec<Arc<Scene>>,
    launch: Launch,
    rules: Rules,
    bins: Bins,
    incidence_rad: f64,
    /// `None` where every ray has its own azimuth.
    direction: Option<Direction>,
    /// The same in a form that many rays run at once, one per scene; none where a scene does not allow it.
    programs: Vec<Program>,
    instructions: InstructionSet,
    /// Whether scenes with a hierarchy are traced in bundles.
    bundles: bool,
}

impl Kernel {
    /// The tracer for the direction given by its angles in degrees; an azimuth of NaN stands for all azimuths.
    pub fn new(
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
    pub fn over(
        sheet: &Sheet,
        rules: &Rules,
        bins: &Bins,
        incidence_deg: f64,
        azimuth_deg: f64,
    ) -> Self {
        let Sheet { scenes, launch } = sheet;
        let incidence_rad = incidence_deg.to_radians();
        let direction = (!azimuth_deg.is_nan()).then(|| {
            Direction::new(
                incidence_rad,
                azimuth_deg.to_radians(),
                rules.refractive_index,
            )
        });
        let program = |number: usize| {
            let entry = launch.pieces().iter().filter(|piece| piece.scene == number);
            let entry = entry.map(Piece::polygon).collect();
            Program::new(&scenes[number], entry, rules, &direction?, bins)
        };
        let programs: Option<Vec<Program>> = (0..scenes.len()).map(program).collect();
        Kernel {
            programs: programs.unwrap_or_default(),
            instructions: InstructionSet::best(),
            // With an azimuth of its own for each, rays part at once.
            bundles: direction.is_some(),
            scenes: scenes.clone(),
            launch: launch.clone(),
            rules: *rules,
            bins: *bins,
            incidence_rad,
            direction,
        }
    }

    /// The same tracer without a program: every ray goes by [`trace`].
    pub fn one_by_one(self) -> Self {
        Kernel {
            programs: Vec::new(),
            bundles: false,
            ..self
        }
    }

    /// The programs of this direction, one per scene; none where it is traced facet by facet.
    pub fn programs(&self) -> &[Program] {
        &self.programs
    }

    /// Traces `samples` of `stream` into `tally`.
    pub fn trace(&self, stream: &Stream, samples: Range<u64>, tally: &mut Tally) {
        match &self.programs[..] {
            [] => self.trace_paths(stream, samples, tally),
            programs => {
                self.instructions
                    .run(programs, &self.launch, &self.bins, stream, samples, tally)
            }
        }
    }

    /// The same facet by facet: in bundles where every scene has a hierarchy for them, else by [`trace`].
    fn trace_paths(&self, stream: &Stream, samples: Range<u64>, tally: &mut Tally) {
        let hierarchies = self.scenes.iter().map(|scene| scene.for_bundles());
        let hierarchies: Option<Vec<&Hierarchy>> = hierarchies.collect();
        let Some(hierarchies) = hierarchies.filter(|_| self.bundles) else {
            return self.trace_one_by_one(stream, samples, tally);
        };
        for (number, (scene, hierarchy)) in self.scenes.iter().zip(hierarchies).enumerate() {
            let mut starts = Vec::new();
            for index in samples.clone() {
                let (chosen, point) = self.launch.entry(stream, index);
                if chosen == number {
                    starts.push((place(&self.launch, point), index));
                }
            }
            starts.sort_unstable();
            for neighbours in starts.chunks(NEIGHBOURS) {
                let indices = neighbours.iter().map(|&(_, index)| index);
                self.trace_neighbours(scene, hierarchy, stream, indices, tally);
            }
        }
    }

    /// Traces samples that enter `scene` near each other.
    fn trace_neighbours(
        &self,
        scene: &Scene,
        hierarchy: &Hierarchy,
        stream: &Stream,
        indices: impl Iterator<Item = u64>,
        tally: &mut Tally,
    ) {
        let mut paths: Vec<(Path, Direction)> = indices
            .map(|index| {
                let direction = self.direction_of(stream, index);
                let point = self.launch.point(stream, index);
                (Path::new(scene, &direction, point), direction)
            })
            .collect();
        // Rays under way, after the first reflection in the order of the facets that they come from.
        let mut order: Vec<(u64, u32)> = (0..paths.len() as u32).map(|which| (0, which)).collect();
        let mut next = Vec::with_capacity(paths.len());
        let mut bundle = Bundle::new();
        while !order.is_empty() {
            for group in order
                .chunk_by(|a, b| a.0 == b.0)
                .flat_map(|alike| alike.chunks(LANES))
            {
                bundle.fill(group.iter().map(|&(_, which)| &paths[which as usize].0.ray));
                self.instructions
                    .nearest_of(hierarchy, scene.facets(), &mut bundle);
                for (lane, &(from, which)) in group.iter().enumerate() {
                    let nearest = bundle.nearest(lane, scene.facets());
                    let (path, direction) = &mut paths[which as usize];
                    let event = scene.event(&path.ray, &nearest);
                    match path.pass(&event, scene, &self.rules, direction) {
                        Some(outcome) => tally.count(&self.bins, &outcome),
                        None => {
                            let facet = nearest.facet.map_or(0, |facet| facet as u64 + 1);
                            next.push((from << 32 | facet, which));
                        }
                    }
                }
            }
            next.sort_unstable();
            std::mem::swap(&mut order, &mut next);
            next.clear();
        }
    }

    fn direction_of(&self, stream: &Stream, index: u64) -> Direction {
        self.direction.unwrap_or_else(|| {
            let azimuth_rad = self.launch.azimuth_rad(stream, index);
            Direction::new(self.incidence_rad, azimuth_rad, self.rules.refractive_index)
        })
    }

    /// The same by [`trace`], ray by ray.
    pub fn trace_one_by_one(&self, stream: &Stream, samples: Range<u64>, tally: &mut Tally) {
        for index in samples {
            let (scene, point) = self.launch.entry(stream, index);
            let direction = self.direction_of(stream, index);
            tally.count(
                &self.bins,
                &trace(&self.scenes[scene], &self.rules, &direction, point),
            );
        }
    }
}

/// Where a point of the entrance lies, neighbours near each other: its column and row of 1,024 each way, bit by bit in
/// turn (Morton 1966).
fn place(launch: &Launch, point: DVec2) -> u32 {
    let [low, high] = launch.box_of_entrance();
    let at = (point - low) / (high - low) * 1024.0;
    let spread = |x: u32| (0..10).fold(0, |sum, bit| sum | ((x >> bit & 1) << (2 * bit)));
    spread((at.x as u32).min(1023)) | spread((at.y as u32).min(1023)) << 1
}
