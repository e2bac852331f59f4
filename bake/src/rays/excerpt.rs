//! Part of a program that the rays of one small part of the entrance can need.

use crate::rays::program::{DEPTH, Program, Step};
use crate::rays::region::{Affine, ROUNDING};
use glam::DVec2;

/// Part of a program that rays from one small part of the entrance can need.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Excerpt {
    /// Steps that such rays can take.
    pub steps: Vec<Step>,
    /// Tests of these steps, without those that all such rays pass.
    pub tests: Vec<Affine>,
}

impl Excerpt {
    /// Takes the part of `program` for rays that enter in the convex hull of `corners`.
    pub(crate) fn refill(&mut self, program: &Program, corners: &[DVec2]) {
        self.steps.clear();
        self.tests.clear();
        // True where an earlier step of the node at that depth takes all its rays.
        let mut closed = [false; DEPTH];
        // Steps deeper than this follow a step that no ray takes.
        let mut skipped = usize::MAX;
        for step in &program.steps {
            if step.from > skipped {
                continue;
            }
            skipped = usize::MAX;
            let first = self.tests.len();
            let mut taken = !closed[step.from];
            for test in &program.tests[step.tests.0..step.tests.1] {
                let values = corners.iter().map(|&corner| test.at(corner));
                let (least, most) = values
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), value| {
                        (l.min(value), m.max(value))
                    });
                taken &= most > -ROUNDING;
                if least < ROUNDING {
                    self.tests.push(*test);
                }
            }
            if !taken {
                self.tests.truncate(first);
                skipped = step.from;
                continue;
            }
            closed[step.from] = self.tests.len() == first;
            closed[step.from + 1] = false;
            self.steps.push(Step {
                tests: (first, self.tests.len()),
                ..*step
            });
        }
    }
}
