//! The tracer of one direction: every ray of a run from its sample to the tally.

use crate::launch::Launch;
use crate::path::{Rules, trace};
use crate::program::Program;
use crate::ray::Direction;
use crate::scene::Scene;
use crate::sequence::Stream;
use crate::simd::InstructionSet;
use crate::tally::{Bins, Tally};
use std::ops::Range;
use std::sync::Arc;

/// What all rays of one direction share.
pub struct Kernel {
    scene: Arc<Scene>,
    launch: Launch,
    rules: Rules,
    bins: Bins,
    incidence_rad: f64,
    /// `None` where every ray has its own azimuth.
    direction: Option<Direction>,
    /// The same in a form that many rays run at once, where the cell allows it.
    program: Option<Program>,
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
        let incidence_rad = incidence_deg.to_radians();
        let direction = (!azimuth_deg.is_nan()).then(|| {
            Direction::new(
                incidence_rad,
                azimuth_deg.to_radians(),
                rules.refractive_index,
            )
        });
        let program =
            direction.and_then(|direction| Program::new(scene, launch, rules, &direction, bins));
        Kernel {
            program,
            instructions: InstructionSet::best(),
            scene: Arc::clone(scene),
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
            program: None,
            ..self
        }
    }

    /// The program of this direction, where there is one.
    pub fn program(&self) -> Option<&Program> {
        self.program.as_ref()
    }

    /// Traces `samples` of `stream` into `tally`.
    pub fn trace(&self, stream: &Stream, samples: Range<u64>, tally: &mut Tally) {
        match &self.program {
            Some(program) => {
                self.instructions
                    .run(program, &self.launch, &self.bins, stream, samples, tally)
            }
            None => self.trace_one_by_one(stream, samples, tally),
        }
    }

    /// The same by [`trace`], ray by ray.
    pub fn trace_one_by_one(&self, stream: &Stream, samples: Range<u64>, tally: &mut Tally) {
        for index in samples {
            let point = self.launch.point(stream, index);
            let direction = self.direction.unwrap_or_else(|| {
                let azimuth_rad = self.launch.azimuth_rad(stream, index);
                Direction::new(self.incidence_rad, azimuth_rad, self.rules.refractive_index)
            });
            tally.count(
                &self.bins,
                &trace(&self.scene, &self.rules, &direction, point),
            );
        }
    }
}
