//! The tracer of one direction: every ray of a run from its sample to the tally.

use crate::launch::{Launch, Piece};
use crate::path::{Rules, trace};
use crate::program::Program;
use crate::ray::Direction;
use crate::scene::Scene;
use crate::sequence::Stream;
use crate::sheet::Sheet;
use crate::simd::InstructionSet;
use crate::tally::{Bins, Tally};
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
            [] => self.trace_one_by_one(stream, samples, tally),
            programs => {
                self.instructions
                    .run(programs, &self.launch, &self.bins, stream, samples, tally)
            }
        }
    }

    /// The same by [`trace`], ray by ray.
    pub fn trace_one_by_one(&self, stream: &Stream, samples: Range<u64>, tally: &mut Tally) {
        for index in samples {
            let (scene, point) = self.launch.entry(stream, index);
            let direction = self.direction.unwrap_or_else(|| {
                let azimuth_rad = self.launch.azimuth_rad(stream, index);
                Direction::new(self.incidence_rad, azimuth_rad, self.rules.refractive_index)
            });
            tally.count(
                &self.bins,
                &trace(&self.scenes[scene], &self.rules, &direction, point),
            );
        }
    }
}
