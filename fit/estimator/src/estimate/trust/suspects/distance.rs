//! Suspects of the floating distances: all are off by one length, as if they were measured from
//! another plane than the sheet; and the photographs at one of them have another focus.

use nalgebra::DVector;

use crate::estimate::scene::{Aerial, Scene};
use crate::estimate::search::layout::{Choice, Layout};
use crate::estimate::search::loss::Loss;
use crate::estimate::search::score::possible;
use crate::estimate::search::select::CLEAR;
use crate::estimate::trust::suspects::{Alternative, FINE, Search};
use crate::model::Further;
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

    /// Returns a worse focus than that of the reference at each of the distances of the worst
    /// photographs, if there are several.
    pub(super) fn of_another_focus(&self) -> Vec<Alternative> {
        const MOST: usize = 3;
        let shots = &self.scene.shots;
        let mut distances: Vec<f64> = Vec::new();
        for &i in &self.goodness.worst_first {
            if !distances.contains(&shots[i].r_mm) {
                distances.push(shots[i].r_mm);
            }
        }
        if distances.len() < 2 || !possible(self.scene, self.fit.choice.kernel).own_blur {
            return Vec::new();
        }
        let all = distances.into_iter().take(MOST);
        all.filter_map(|r_mm| self.another_focus(r_mm)).collect()
    }

    fn another_focus(&self, r_mm: f64) -> Option<Alternative> {
        let own = self.fit.choice;
        let choice = Choice {
            further: own.further.and(Further::OWN_BLUR),
            ..own
        };
        let shots = self.scene.shots.iter().map(|shot| Aerial {
            has_own_blur: shot.r_mm == r_mm,
            ..shot.clone()
        });
        let scene = self.scene.with(shots.collect());
        let fit = self.at_least_anew(&scene, &[choice])?.fit;
        let column = Layout::new(choice, scene.groups.len()).own_blur()?;
        let variance_mm2 = fit.solution.parameters[column];
        // What is sharper than the reference is seldom a matter of focus.
        let blur_mm = (variance_mm2 > 0.0).then(|| variance_mm2.sqrt())?;
        let what = format!(
            "the photographs at {r_mm} mm are blurred by {:.2} px more than the reference, and the \
            others are not (another focus: photograph them again, focused on their edge)",
            blur_mm / scene.optics.camera.pitch_mm
        );
        let there = self.scene.shots.iter().filter(|shot| shot.r_mm == r_mm);
        let captures = there.map(|shot| shot.image.clone()).collect();
        Some(Alternative {
            choices: vec![choice],
            cost: CLEAR,
            is_blur: true,
            ..self.alternative(what, captures, scene)
        })
    }

    /// Returns the offset that fits the MTFs best, mm, and the scene with it.
    fn offset(&self, choice: Choice) -> Option<(f64, Scene)> {
        let start = self
            .at_least(self.scene, &[choice])?
            .fit
            .solution
            .parameters;
        let mean_mm = self.scene.mean_distance_mm();
        let layout = Layout::new(choice, self.scene.groups.len());
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
