//! The suspect that all floating distances are off by one length, as if they were measured from
//! another plane than the sheet.

use nalgebra::DVector;

use crate::estimate::scene::{Aerial, Scene};
use crate::estimate::search::layout::{Choice, Layout};
use crate::estimate::search::loss::Loss;
use crate::estimate::search::select::CLEAR;
use crate::estimate::trust::suspects::{Alternative, FINE, Search};
use edges::names::Kernel;
use edges::numerics::{Stop, least_squares};

/// Least distance that is tried, as a share of the mean distance.
const NEAREST: f64 = 0.02;

/// Step of the offset for its derivative, as a share of the mean distance.
const STEP: f64 = 1e-4;

impl Search<'_> {
    /// Adds the distances with the offset that fits best, if the blur depends on the distances.
    ///
    /// The offset is one more parameter of a fit to the MTFs. A blur that falls with the distance
    /// by another law than the best kernel may be that of kernel angular at other distances.
    pub(super) fn other_origin(&self, all: &mut Vec<Alternative>) {
        let own = self.fit.choice;
        let was_tried = |kernel| self.tried.iter().any(|row| row.choice.kernel == kernel);
        let kernel = match own.kernel {
            Kernel::Wave | Kernel::Angular => own.kernel,
            Kernel::Eq1 if was_tried(Kernel::Angular) => Kernel::Angular,
            _ => return,
        };
        let shots = &self.scene.shots;
        // At one distance A takes what an offset changes.
        if kernel == Kernel::Angular && shots.iter().all(|shot| shot.r_mm == shots[0].r_mm) {
            return;
        }
        let choice = Choice { kernel, ..own };
        let Some((offset_mm, scene)) = self.offset(choice) else {
            return;
        };
        let side = if offset_mm > 0.0 { "short" } else { "long" };
        let what = format!(
            "all floating distances are stated {:.1} mm too {side} (measured from another plane \
            than the sheet?)",
            offset_mm.abs()
        );
        all.push(Alternative {
            choices: vec![choice],
            // The offset is one more parameter.
            cost: 1.0 + CLEAR,
            ..self.alternative(what, Vec::new(), scene)
        });
    }

    /// Returns the offset that fits the MTFs best, mm, and the scene with it.
    fn offset(&self, choice: Choice) -> Option<(f64, Scene)> {
        let start = self
            .at_least(self.scene, &[choice])?
            .fit
            .solution
            .parameters;
        let mean_mm = self.scene.mean_distance_mm();
        let layout = Layout::of(choice, self.scene);
        let last = layout.parameters();
        let evaluate = |at: &DVector<f64>| {
            let blur = at.rows(0, last).into_owned();
            let of = |offset: f64| {
                let scene = self.farther(offset * mean_mm);
                Loss::Mtf(&scene).evaluate(&layout, &blur)
            };
            let (residuals, jacobian) = of(at[last]);
            let by_offset = (of(at[last] + STEP).0 - of(at[last] - STEP).0) / (2.0 * STEP);
            let mut jacobian = jacobian.insert_column(last, 0.0);
            jacobian.set_column(last, &by_offset);
            (residuals, jacobian)
        };
        let solution = least_squares(start.insert_row(last, 0.0), FINE, evaluate);
        let offset_mm = solution.parameters[last] * mean_mm;
        (solution.stop != Stop::Failed && offset_mm.is_finite())
            .then(|| (offset_mm, self.farther(offset_mm)))
    }

    /// Returns the scene with all distances longer by `offset_mm`.
    fn farther(&self, offset_mm: f64) -> Scene {
        let least_mm = NEAREST * self.scene.mean_distance_mm();
        let shots = self.scene.shots.iter().map(|shot| Aerial {
            r_mm: (shot.r_mm + offset_mm).max(least_mm),
            ..shot.clone()
        });
        self.scene.with(shots.collect())
    }
}
