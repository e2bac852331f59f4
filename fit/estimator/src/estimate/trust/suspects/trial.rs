//! Trials of mistakes to first order: one Gauss-Newton step by the MTFs, without a fit.
//!
//! A mistake changes the conditions of some photographs, and many mistakes share a photograph's
//! conditions. So each photograph is compared with the model once under each of its conditions, and
//! a few numbers of it are kept: the normal matrix of its differences. The sum of such matrices is
//! that of a mistake, and its factor holds the least sum of squares. A hundred mistakes take a few
//! times as long as one fit.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::{DMatrix, DVector, Matrix3};

use crate::compare::Weights;
use crate::estimate::scene::perturbed::{Conditions, OtherIndex};
use crate::estimate::scene::{Aerial, Place, Scene};
use crate::estimate::search::compared::compare;
use crate::estimate::search::layout::{Choice, Layout};
use crate::estimate::search::optimum::Optimum;
use crate::estimate::trust::suspects::Otherwise;
use edges::numerics::factor;

/// Greatest change of the logarithm of a parameter in a step. The model is far from linear beyond
/// it.
const FARTHEST: f64 = 1.0;

/// Conditions of one photograph, its number, and the table in which its direction is looked up.
type Key = (usize, usize, Option<[u64; 2]>, [u64; 5]);

/// Normal matrix of the columns (ln spread, ln c, difference) of one photograph.
type Normal = Matrix3<f64>;

/// Trials of one candidate, about its optimum on the MTFs of the scene as it is stated.
pub(super) struct Trials<'a> {
    scene: &'a Scene,
    choice: Choice,
    at: &'a DVector<f64>,
    /// Normal matrices that are known; `None` for a photograph without light or direction.
    known: Mutex<HashMap<Key, Option<Arc<Normal>>>>,
}

impl<'a> Trials<'a> {
    /// Prepares the trials of a candidate that was fitted to the MTFs.
    pub(super) fn new(scene: &'a Scene, fit: &'a Optimum) -> Trials<'a> {
        Trials {
            scene,
            choice: fit.choice,
            at: &fit.solution.parameters,
            known: Mutex::default(),
        }
    }

    /// Returns the sum of squares that a mistake leaves after a step, less its degrees of freedom.
    /// Returns `None` if a photograph would have no light, or if the table lacks its direction.
    pub(super) fn excess(&self, otherwise: &Otherwise) -> Option<f64> {
        let mut groups: Vec<f64> = otherwise
            .conditions
            .iter()
            .map(|c| c.incidence_deg)
            .collect();
        groups.sort_by(f64::total_cmp);
        groups.dedup();
        let layout = Layout::new(self.choice, groups.len(), self.scene.distances_mm.len());
        let size = layout.parameters();
        let mut normal = DMatrix::zeros(size + 1, size + 1);
        let mut observations = 0_usize;
        let pairs = self.scene.shots.iter().zip(&otherwise.conditions);
        for (number, (shot, conditions)) in pairs.enumerate() {
            let own = self.normal(number, shot, otherwise, conditions)?;
            observations += shot.view.mtf.modulus.len() - 1;
            let group = groups
                .iter()
                .position(|&deg| deg == conditions.incidence_deg);
            let columns = [layout.spread(group?), layout.c(), Some(size)];
            for (i, row) in columns.iter().enumerate() {
                for (j, column) in columns.iter().enumerate() {
                    if let (Some(row), Some(column)) = (row, column) {
                        normal[(*row, *column)] += own[(i, j)];
                    }
                }
            }
        }
        let factor = factor::of(normal);
        let mut damping = 0.0;
        let step = loop {
            let step = factor::damped_step(&factor, size, size, damping);
            if step.iter().all(|by| by.abs() <= FARTHEST) || damping > 1e6 {
                break step;
            }
            damping = (10.0 * damping).max(1e-4);
        };
        let left = factor.column(size) - factor.columns(0, size) * step;
        let excess = left.norm_squared() - observations as f64 + size as f64;
        excess.is_finite().then_some(excess)
    }

    /// Returns the normal matrix of a photograph under these conditions.
    fn normal(
        &self,
        number: usize,
        shot: &Aerial,
        otherwise: &Otherwise,
        conditions: &Conditions,
    ) -> Option<Arc<Normal>> {
        let Conditions {
            incidence_deg,
            azimuth_deg,
            r_mm,
            exposure: _,
            axis_turn_rad,
            seen_in_mirror,
        } = *conditions;
        let bits = [
            incidence_deg,
            azimuth_deg.unwrap_or(f64::NAN),
            r_mm,
            axis_turn_rad,
            f64::from(u8::from(seen_in_mirror)),
        ];
        let index = otherwise.index.map(OtherIndex::bits);
        let table = std::ptr::from_ref(otherwise.table) as usize;
        let key = (number, table, index, bits.map(f64::to_bits));
        let known = |key: &Key| {
            let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
            known.get(key).cloned()
        };
        if let Some(found) = known(&key) {
            return found;
        }
        let moved = self
            .scene
            .moved(shot, otherwise.table, otherwise.index, conditions)
            .ok()
            .filter(|moved| moved.direction.returned.retroreflected > 0.0);
        let found = moved.map(|moved| Arc::new(self.compared(shot, &moved)));
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        known.insert(key, found.clone());
        found
    }

    /// Compares a photograph, under other conditions, with the model at the parameters of its
    /// incidence there.
    fn compared(&self, shot: &Aerial, moved: &Aerial) -> Normal {
        let layout = Layout::of(self.choice, self.scene);
        let mut groups = self.scene.groups.iter();
        let group = groups.position(|&deg| deg == moved.incidence_deg);
        let place = Place {
            group: group.unwrap_or(shot.place.group),
            ..shot.place
        };
        let blur = layout.blur(self.at, place);
        let part = compare(moved, None, self.choice, blur);
        let weighed = |values: &Vec<f64>| shot.view.weigh(Weights::Noise, values);
        let mut derivatives = part.derivatives.iter().map(weighed);
        let by_spread = layout.spread(0).and_then(|_| derivatives.next());
        let by_c = layout.c().and_then(|_| derivatives.next());
        let columns = [by_spread, by_c, Some(weighed(&part.difference))];
        Normal::from_fn(|i, j| match (&columns[i], &columns[j]) {
            (Some(a), Some(b)) => a.dot(b),
            _ => 0.0,
        })
    }
}
